"""A chart of a table."""

from typing import Annotated, Literal

from hairpipe.data import Table
from hairpipe.graph import File, Workspace, node
from hairpipe.units import Interval, Pixels, Suffixes

Scale = Literal["linear", "log"]


@node(frames="once")
def plot_table(
    tables: tuple[Table, ...],
    workspace: Workspace,
    *,
    x: str,
    y: tuple[str, ...],
    series: str | None = None,
    cases: tuple[str, ...] = (),
    x_scale: Scale = "linear",
    y_scale: Scale = "linear",
    label: str | None = None,
    title: str = "",
    levels: tuple[float, ...] = (),
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 1200,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 750,
) -> Annotated[File, Suffixes((".png",))]:
    """PNG of lines: columns of a table against another of its columns; several tables are laid below each other.

    x        column along the abscissa, numbers or texts
    y        columns of numbers along the ordinate
    series   column whose values split the rows into lines
    cases    names of the tables, in order: a column "case" names the one a row is from
    x_scale  of the abscissa
    y_scale  of the ordinate
    label    of the ordinate; the name of the column where there is one
    title    above the chart
    levels   of the ordinate at which a line goes across, such as a target
    width    of the picture
    height   of the picture
    """
    from hairpipe.chart.lines import Columns, draw_table
    from hairpipe.io.table import lay_below

    path, size = workspace / "chart.png", (width, height)
    table = lay_below(tables, cases)
    columns = Columns(x, y, series)
    draw_table(path, table, columns, scales=(x_scale, y_scale), label=label, title=title, levels=levels, size=size)
    return File(path)
