"""A solid torus."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.elastic.elastic_values import Solid
from hairpipe.units import Gt, Interval, Metres


@node(frames="once")
def make_torus(
    *,
    ring: Annotated[Metres, Gt(0.0)] = 0.5,
    tube: Annotated[Metres, Gt(0.0)] = 0.2,
    height: Annotated[Metres, Interval(ge=0.0, le=1000.0)] = 1.6,
    layers: Annotated[int, Interval(ge=1, le=20)] = 2,
    around: Annotated[int, Interval(ge=3, le=1000)] = 36,
) -> Solid:
    """Build tetrahedra that fill a torus lying flat.

    ring    radius of the centre line of the tube
    tube    radius of the tube
    height  height of the lowest points above the ground
    layers  number of layers of tetrahedra across the radius of the tube
    around  number of prisms along the ring, each of 18 layers^2 tetrahedra
    """
    from hairpipe.graphs.experiments.elastic.torus import build_torus

    return build_torus(ring, tube, layers, around, height)
