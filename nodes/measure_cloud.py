"""Cohesion of hair made of particles."""

from hairpipe.engine import Reached, node
from hairpipe.values import Cloud, Particles, Table


@node(frames="once")
def measure_cloud(cloud: Reached[Cloud], particles: Particles) -> Table:
    """Measure clustering of particles, stretch and lost links over the frames reached: one row."""
    from hairpipe.measure.cloud import cloud_table

    return cloud_table(cloud, particles)
