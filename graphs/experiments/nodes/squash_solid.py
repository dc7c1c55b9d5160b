"""Degenerate start shapes of a solid."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.elastic.elastic_values import Solid
from hairpipe.graphs.experiments.elastic.squash import Shape
from hairpipe.units import Ge


@node(frames="once")
def squash_solid(solid: Solid, *, shape: Shape = "plane", seed: Annotated[int, Ge(0)] = 0) -> Solid:
    """Move the particles of a solid to a plane, a line, their mirror image, random places or a point.

    shape  target shape about the centre of the particles
    seed   seed of the random places
    """
    from hairpipe.graphs.experiments.elastic.squash import squash

    return squash(solid, shape, seed)
