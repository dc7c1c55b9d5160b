"""A chart of what is worth its cost."""

from typing import Annotated

from hairpipe.data import Table
from hairpipe.graph import File, Workspace, node
from hairpipe.units import Interval, Pixels, Suffixes


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
    """PNG of points on logarithmic scales, each with its name, the front among them as a line, failures as crosses.

    x       column of numbers along the abscissa
    y       column of numbers along the ordinate
    label   column of texts written next to the points
    series  column of texts: points of one are of one colour
    failed  column of texts: nothing, or what failed and where; such a point stands at the upper edge if it is beyond
    front   column of numbers that are not 0 for points that the line goes through
    low     column of numbers where a bar at each point begins; empty: there are no bars
    high    column of numbers where it ends
    floor   column of numbers below which nothing is told apart, a band; empty: there is none
    spread  column of ratios of spreads, written beside names where they are not near 1; empty: there is none
    joined  series whose points a line joins, in the order of the table
    title   above the chart
    width   of the picture
    height  of the picture
    """
    from hairpipe.chart.front import Columns, draw_front

    path, columns = workspace / "front.png", Columns(x, y, label, series, failed, front, low, high, floor, spread)
    draw_front(path, table, columns, joined=joined, title=title, size=(width, height))
    return File(path)
