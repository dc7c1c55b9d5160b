"""How well hair of particles holds together, as numbers."""

from hairpipe.data import Cloud, Particles, Table
from hairpipe.graph import Reached, node


@node(frames="once")
def measure_cloud(cloud: Reached[Cloud], particles: Particles) -> Table:
    """How far particles clump, hair is stretched and links are lost: one row, of the frames that were reached."""
    from hairpipe.measure.cloud import cloud_table

    return cloud_table(cloud, particles)
