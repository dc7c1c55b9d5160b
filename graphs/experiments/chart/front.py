"""A Pareto front: variants by cost and error, those that none beats in both joined by a line."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.labels import Label, place_labels
from hairpipe.graphs.experiments.chart.lines import check_columns
from hairpipe.graphs.experiments.chart.sheet import COLOURS, sheet
from hairpipe.values import Table

FAILED, MARGIN = "#d9482b", 0.07
"""Colour of what failed; room around the points, over the width and height of the axes."""
NEAR = 0.8, 1.25
"""Ratios of spreads between which they are not written."""
MARKERS = "osD^vPh<>p"


class Columns(NamedTuple):
    """Names of the columns that are drawn; see `plot_front`."""

    x: str
    y: str
    label: str
    series: str
    failed: str
    front: str
    low: str = ""
    high: str = ""
    floor: str = ""
    spread: str = ""


class Look(NamedTuple):
    """How the points of a series are drawn."""

    name: str
    colour: str
    marker: str
    line: Literal["-", ""]


def draw_front(
    path: Path,
    table: Table,
    columns: Columns,
    *,
    joined: Sequence[str] = (),
    title: str = "",
    size: tuple[int, int] = (1800, 1200),
) -> None:
    """Draw a point for every row, and write a PNG; BadInput where there is no such column, or nothing to draw.

    What failed is a cross where it is, or at the edge where that is too far away. What is 0 is at the lower edge. Bars
    are intervals, low and high, cut at the edges. Below the largest floor nothing is significant: it is a band, and
    what is in it stands at its upper edge, hollow. A ratio of spreads is written next to the name, but near 1.

    joined  series whose points a line joins, in the order of the table
    size    of the picture [px]
    """
    optional = [name for name in (columns.low, columns.high, columns.floor, columns.spread) if name]
    check_columns(table, [name for name in columns if name], [columns.x, columns.y, columns.front, *optional])
    x = table.numbers[columns.x]
    y = table.numbers[columns.y]
    floor = floor_of(table, columns)
    untold = (y <= floor) & (floor > 0.0)
    y = np.where(untold, floor, y)
    bars = [table.numbers[name] if name else np.full(len(y), np.nan) for name in (columns.low, columns.high)]
    names = labels_of(table, columns)
    failed = texts(table, columns.failed)
    good = np.array([not text for text in failed]) & (x >= 0) & (y >= 0) & np.isfinite(x) & np.isfinite(y)
    if not good.any():
        raise BadInput("no variant has a cost and an error", right="at least one variant without failure")
    low, high = limits_of(x[np.isfinite(x)], np.concatenate([y[good], bars[1][good & np.isfinite(bars[1])]]))
    places = np.stack([clipped(x, low[0], high[0]), clipped(y, low[1], high[1])], axis=1)
    groups = list(dict.fromkeys(texts(table, columns.series)))
    with sheet(path, *size) as (axes,):
        prepare(axes, low, high, columns, title)
        draw_line(axes, places[good & (table.numbers[columns.front] != 0)])
        labels, keys = [], []
        for n, group in enumerate(groups):
            mine = np.array([other == group for other in texts(table, columns.series)])
            colour, marker = COLOURS[n % len(COLOURS)], MARKERS[n % len(MARKERS)]
            look = Look(group, colour, marker, "-" if group in joined else "")
            keys.append(draw_group(axes, places[mine & good], look, untold[mine & good]))
            barred = mine & good & np.isfinite(bars).all(axis=0)
            if barred.any():
                ends = [clipped(bar[barred], low[1], high[1]) for bar in bars]
                axes.vlines(x[barred], *ends, colors=colour, linewidth=1.0, zorder=3)
            labels += [Label(names[k], tuple(places[k]), colour) for k in np.flatnonzero(mine & good)]
        lost = np.flatnonzero(~good)
        labels += [Label(f"{names[k]}: {failed[k] or 'no error'}", tuple(places[k]), FAILED) for k in lost]
        keys.append(Line2D([], [], linewidth=5, color="#bbbbbb", alpha=0.6, label="Pareto front"))
        if floor > 0.0:
            keys.append(axes.axhspan(low[1], floor, color="#eeeeee", zorder=0, label="not significantly different"))
        if len(lost):
            axes.plot(*places[lost].T, linestyle="", marker="X", markersize=10, color=FAILED, zorder=5, clip_on=False)
            cross = Line2D(
                [], [], linestyle="", marker="X", markersize=8, color=FAILED, label="failed, there or beyond"
            )
            keys.append(cross)
        axes.figure.legend(handles=[key for key in keys if key.get_label()], loc="outside right upper", frameon=False)
        place_labels(axes, labels)


def floor_of(table: Table, columns: Columns) -> float:
    """Return the largest floor of a table, 0 without any."""
    if not columns.floor:
        return 0.0
    return float(np.nanmax(table.numbers[columns.floor], initial=0.0))


def labels_of(table: Table, columns: Columns) -> list[str]:
    """Return what is written next to the points."""
    names = texts(table, columns.label)
    spreads = table.numbers[columns.spread] if columns.spread else np.full(len(names), np.nan)
    far = (spreads < NEAR[0]) | (spreads > NEAR[1])
    return [
        f"{name}, spread {ratio:.2g}" if is_far else name
        for name, ratio, is_far in zip(names, spreads, far, strict=True)
    ]


def texts(table: Table, name: str) -> list[str]:
    """Return a column as texts."""
    return [str(value) for value in table[name]]


def limits_of(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest x and y of the axes: room around costs and the errors of what did not fail.

    Those that are not more than 0 have no place on a scale of logarithms; around 1 there is room where no other is.
    """
    known = [np.log(values[values > 0.0]) if (values > 0.0).any() else np.zeros(1) for values in (x, y)]
    low, high = np.array([(values.min(), values.max()) for values in known]).T
    room = MARGIN * np.maximum(high - low, 1.0)
    return np.exp(low - room), np.exp(high + room)


def clipped(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Keep values on the axes; what is not finite is at the upper edge."""
    return np.clip(np.where(np.isfinite(values), values, high), low, high)


def prepare(axes: Axes, low: np.ndarray, high: np.ndarray, columns: Columns, title: str) -> None:
    """Set scales, limits and names of the axes."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(lambda value, place: f"{value:g}" if f"{value:e}"[0] in "25" else "")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel(columns.x)
    axes.set_ylabel(columns.y)
    axes.set_title(title)


def draw_line(axes: Axes, points: np.ndarray) -> None:
    """Draw the front through its points, (n, 2), in stairs: what can be had for so much."""
    ordered = points[np.argsort(points[:, 0])]
    axes.step(*ordered.T, where="post", color="#bbbbbb", alpha=0.6, linewidth=5, zorder=1, solid_joinstyle="round")


def draw_group(axes: Axes, points: np.ndarray, look: Look, hollow: np.ndarray) -> Line2D:
    """Draw the points of a group, (n, 2), in the order of the table, some hollow, (n,) bool; return its key."""
    axes.plot(*points.T, linestyle=look.line, linewidth=0.8, alpha=0.5, color=look.colour, zorder=2)
    dots = {"marker": look.marker, "markersize": 6, "color": look.colour, "markeredgecolor": "white", "clip_on": False}
    axes.plot(*points[~hollow].T, linestyle="", zorder=4, **dots)
    empty = {"markerfacecolor": "white", "markeredgecolor": look.colour}
    axes.plot(*points[hollow].T, linestyle="", zorder=4, **{**dots, **empty})
    return Line2D([], [], linestyle=look.line, label=look.name, **dots)
