"""How hair of particles splits and merges, as numbers."""

from hairpipe.data import Cloud, Particles, Table
from hairpipe.graph import Frames, node


@node(frames="once")
def measure_split(cloud: Frames[Cloud], particles: Particles) -> Table:
    """Gap between the halves of hair that is parted, links across it, and what ends on the wrong side: one row."""
    from hairpipe.measure.cloud import split_table

    return split_table(cloud, particles)
