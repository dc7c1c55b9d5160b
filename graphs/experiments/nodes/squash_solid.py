"""A solid out of shape."""

from typing import Annotated

from hairpipe.graphs.experiments.elastic.squash import Shape

from hairpipe.data import Solid
from hairpipe.graph import node
from hairpipe.units import Ge


@node(frames="once")
def squash_solid(solid: Solid, *, shape: Shape = "plane", seed: Annotated[int, Ge(0)] = 0) -> Solid:
    """The particles of a solid on a plane, on a line, mirrored, at random or in one point: where a test may start.

    shape  they are moved to, about their middle
    seed   of the random places
    """
    from hairpipe.graphs.experiments.elastic.squash import squash

    return squash(solid, shape, seed)
