"""A chart of what fails where."""

from typing import Annotated

from hairpipe.data import Table
from hairpipe.graph import File, Workspace, node
from hairpipe.units import Ge, Gt, Interval, Pixels, Suffixes

Limits = tuple[Annotated[float, Gt(0.0)], Annotated[float, Gt(0.0)]]


@node(frames="once")
def plot_map(
    tables: tuple[Table, ...],
    workspace: Workspace,
    *,
    cases: tuple[str, ...],
    x: str,
    y: str,
    value: str,
    marks: str,
    limits: Limits = (0.01, 100.0),
    columns: Annotated[int, Ge(1)] = 4,
    title: str = "",
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 2400,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 1500,
) -> Annotated[File, Suffixes((".png",))]:
    """PNG of maps, one a table: a coloured cell for every row, with the first letters of what failed.

    cases    names of the tables, in order
    x        column of numbers along the abscissa
    y        column of texts along the ordinate
    value    column of numbers that colours the cells
    marks    column of texts: what failed, parted by commas, nothing, or "not run"
    limits   of the colours
    columns  of maps
    title    above them
    width    of the picture
    height   of the picture
    """
    from hairpipe.chart.maps import MapColumns, draw_maps
    from hairpipe.io.table import lay_below

    path, size = workspace / "map.png", (width, height)
    table = lay_below(tables, cases)
    shown = MapColumns("case", x, y, value, marks)
    draw_maps(path, table, shown, limits=limits, across=columns, title=title, size=size)
    return File(path)
