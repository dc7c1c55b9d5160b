"""Half a hollow torus."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.elastic.elastic_values import Shell
from hairpipe.units import Gt, Interval, Metres


@node(frames="once")
def make_noodle(
    *,
    ring: Annotated[Metres, Gt(0.0)] = 0.5,
    tube: Annotated[Metres, Gt(0.0)] = 0.15,
    height: Annotated[Metres, Interval(ge=0.0, le=1000.0)] = 1.6,
    along: Annotated[int, Interval(ge=1, le=1000)] = 32,
    around: Annotated[int, Interval(ge=3, le=1000)] = 16,
) -> Shell:
    """Build triangles of a tube that is bent into half a circle, open at both ends and lying flat.

    ring    radius of the centre line of the tube
    tube    radius of the tube
    height  height of the lowest points above the ground
    along   number of quads along the half circle, each of two triangles
    around  number of quads around the tube
    """
    from hairpipe.graphs.experiments.elastic.sheets import build_noodle

    return build_noodle(ring, tube, along, around, height)
