"""Splitting and merging of hair made of particles."""

from hairpipe.engine import Frames, node
from hairpipe.values import Cloud, Particles, Table


@node(frames="once")
def measure_split(cloud: Frames[Cloud], particles: Particles) -> Table:
    """Measure the gap after parting, links across it, and strands on the wrong side: one row."""
    from hairpipe.measure.cloud import split_table

    return split_table(cloud, particles)
