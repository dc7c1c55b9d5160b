"""A square of cloth."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.elastic.elastic_values import Shell
from hairpipe.units import Gt, Interval, Metres


@node(frames="once")
def make_cloth(
    *,
    size: Annotated[Metres, Gt(0.0)] = 1.0,
    height: Annotated[Metres, Interval(ge=0.0, le=1000.0)] = 1.4,
    cells: Annotated[int, Interval(ge=1, le=1000)] = 20,
) -> Shell:
    """Build triangles of a level square that is pinned at the two back corners.

    size    length of an edge
    height  height above the ground
    cells   number of cells along an edge, each of two triangles
    """
    from hairpipe.graphs.experiments.elastic.sheets import build_cloth

    return build_cloth(size, cells, height)
