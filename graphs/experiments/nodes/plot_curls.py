"""A phase diagram of naturally curved strands that hang."""

from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Interval, Pixels, Suffixes
from hairpipe.values import Table


@node(frames="once")
def plot_curls(
    shapes: Table,
    border: Table,
    pitches: Table,
    workspace: Workspace,
    *,
    ratio: Annotated[float, Interval(gt=0.0, le=1.0)] = 1 / 1.35,
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 1800,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 800,
) -> Annotated[File, Suffixes((".png",))]:
    """Draw shapes of hanging arcs with the borders of rod theory, and the pitch along a helix, as PNG.

    ratio   torsional over bending stiffness
    width   width of the picture
    height  height of the picture
    """
    from hairpipe.graphs.experiments.chart.curls import draw_curls

    path = workspace / "curls.png"
    draw_curls(path, shapes, border, pitches, ratio=ratio, size=(width, height))
    return File(path)
