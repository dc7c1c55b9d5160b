"""A chart of failures over two parameters."""

from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Ge, Gt, Interval, Pixels, Suffixes
from hairpipe.values import Table

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
    """Draw one map per table as PNG: a coloured cell for each row, with the initials of its failures.

    cases    names of the tables, in order
    x        name of the column of numbers on the abscissa
    y        name of the column of texts on the ordinate
    value    name of the column of numbers that gives the colour
    marks    name of the column of failures: names separated by commas, empty, or "not run"
    limits   lower and upper limit of the colour scale
    columns  number of maps in a row
    title    text above the picture
    width    width of the picture
    height   height of the picture
    """
    from hairpipe.formats.values import lay_below
    from hairpipe.graphs.experiments.chart.maps import MapColumns, draw_maps

    path = workspace / "map.png"
    size = (width, height)
    table = lay_below(tables, cases)
    shown = MapColumns("case", x, y, value, marks)
    draw_maps(path, table, shown, limits=limits, across=columns, title=title, size=size)
    return File(path)
