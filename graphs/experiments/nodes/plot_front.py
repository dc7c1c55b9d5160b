"""A chart of cost and error with the Pareto front."""

from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Interval, Pixels, Suffixes
from hairpipe.values import Table


@node(frames="once")
def plot_front(
    table: Table,
    workspace: Workspace,
    *,
    x: str = "seconds per frame",
    y: str = "strand error [% of length]",
    label: str = "case",
    series: str = "group",
    failed: str = "failed",
    front: str = "on the front",
    low: str = "",
    high: str = "",
    floor: str = "",
    spread: str = "",
    joined: tuple[str, ...] = (),
    title: str = "",
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 1800,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 1200,
) -> Annotated[File, Suffixes((".png",))]:
    """Draw labelled points on logarithmic scales as PNG, with the Pareto front as a line and failures as crosses.

    x       name of the column of numbers on the abscissa
    y       name of the column of numbers on the ordinate
    label   name of the column of texts next to the points
    series  name of the column of texts that separates points by colour
    failed  name of the column of failures: empty, or kind and place; a failed point beyond the chart is drawn at its
            upper edge
    front   name of the column of numbers that are not 0 for points on the front
    low     name of the column of lower ends of error bars; empty: no bars
    high    name of the column of upper ends of error bars
    floor   name of the column of resolution limits, drawn as a band; empty: none
    spread  name of the column of ratios of spreads, written next to points where they differ from 1; empty: none
    joined  names of the series with points joined by a line, in the order of the table
    title   text above the chart
    width   width of the picture
    height  height of the picture
    """
    from hairpipe.graphs.experiments.chart.front import Columns, draw_front

    path = workspace / "front.png"
    columns = Columns(x, y, label, series, failed, front, low, high, floor, spread)
    draw_front(path, table, columns, joined=joined, title=title, size=(width, height))
    return File(path)
