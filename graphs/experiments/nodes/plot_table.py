"""A chart of a table."""

from typing import Annotated, Literal

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Interval, Pixels, Suffixes
from hairpipe.values import Table

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
    """Draw columns of tables over another column as PNG lines; tables are concatenated.

    x        name of the column of numbers or texts on the abscissa
    y        names of the columns of numbers on the ordinate
    series   name of the column that separates rows into lines
    cases    names of the tables, in order, for a new column "case"
    x_scale  scale of the abscissa: linear or logarithmic
    y_scale  scale of the ordinate: linear or logarithmic
    label    label of the ordinate; by default the name of the only column
    title    text above the chart
    levels   values of the ordinate with a horizontal line, such as a target
    width    width of the picture
    height   height of the picture
    """
    from hairpipe.formats.values import lay_below
    from hairpipe.graphs.experiments.chart.lines import Columns, draw_table

    path = workspace / "chart.png"
    size = (width, height)
    table = lay_below(tables, cases)
    columns = Columns(x, y, series)
    draw_table(path, table, columns, scales=(x_scale, y_scale), label=label, title=title, levels=levels, size=size)
    return File(path)
