"""Line charts of a table: columns against another one."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.sheet import COLOURS, INK, shades, sheet
from hairpipe.values import Table

Scale = Literal["linear", "log"]
CLOSEST = 0.045
"""Distance that labels keep, over the height of the axes."""


@dataclass(frozen=True)
class Line:
    """A line with its name: numbers or texts along x, numbers along y."""

    label: str
    x: np.ndarray | list[str]
    y: np.ndarray


@dataclass(frozen=True)
class Columns:
    """Columns of a table that lines are drawn from.

    x       column of numbers or texts along the abscissa
    y       columns of numbers along the ordinate
    series  column whose values split the rows into lines; all rows are one line without
    """

    x: str
    y: Sequence[str]
    series: str | None = None


def draw_table(
    path: Path,
    table: Table,
    columns: Columns,
    *,
    scales: tuple[Scale, Scale] = ("linear", "linear"),
    label: str | None = None,
    title: str = "",
    levels: Sequence[float] = (),
    size: tuple[int, int] = (1200, 750),
) -> None:
    """Draw columns of a table as lines, and write a PNG; BadInput where there is no such column.

    scales  of x and y
    label   of the y axis; the column's name where there is one
    levels  of y at which a line is drawn across
    size    of the picture [px]
    """
    x, y, series = columns.x, columns.y, columns.series
    check_columns(table, [x, *y, *([series] if series else [])], y)
    lines = lines_of(table, columns)
    ordered = series in table.numbers and len(y) == 1 and len(lines) > 2
    colours = shades(len(lines)) if ordered else [COLOURS[n % len(COLOURS)] for n in range(len(lines))]
    join = "-" if x in table.numbers else ""
    with sheet(path, *size) as (axes,):
        for line, colour in zip(lines, colours, strict=True):
            axes.plot(line.x, line.y, linestyle=join, marker="o" if len(line.y) <= 40 else "", color=colour)
        for level in levels:
            axes.axhline(level, color=INK, linewidth=0.8, linestyle="--", zorder=1)
            axes.annotate(
                f"{level:g}", (0, level), (2, 2), xycoords=axes.get_yaxis_transform(), textcoords="offset points"
            )
        axes.set_title(title)
        axes.set_xlabel(x)
        axes.set_ylabel(label or (y[0] if len(y) == 1 else ""))
        if x in table.numbers:
            axes.set_xscale(scales[0], **({"nonpositive": "mask"} if scales[0] == "log" else {}))
        axes.set_yscale(scales[1], **({"nonpositive": "mask"} if scales[1] == "log" else {}))
        if len(lines) > 1:
            label_lines(axes, lines, colours, series if series in table.numbers else None)


def check_columns(table: Table, names: Sequence[str], numbers: Sequence[str]) -> None:
    """Raise BadInput where a table has no such columns, or texts where numbers are drawn."""
    for name in names:
        if name not in table.names:
            raise BadInput(f"no column '{name}'", right=f"one of {', '.join(table.names)}")
    for name in numbers:
        if name in table.texts:
            raise BadInput(f"column '{name}' holds texts", right="a column of numbers along y")


def lines_of(table: Table, columns: Columns) -> list[Line]:
    """Split a table into lines, in the order in which their names first appear."""
    x, y, series = columns.x, columns.y, columns.series
    values = list(table[series]) if series else [""] * len(table)
    lines = []
    for value in dict.fromkeys(values):
        rows = [row for row, other in enumerate(values) if other == value]
        name = value if isinstance(value, str) else f"{value:.4g}"
        for column in y:
            label = ", ".join(filter(None, (name, column if len(y) > 1 else "")))
            along = [table.texts[x][row] for row in rows] if x in table.texts else table.numbers[x][rows]
            lines.append(Line(label, along, table.numbers[column][rows]))
    return lines


def label_lines(axes: Axes, lines: list[Line], colours: list[Any], heading: str | None) -> None:
    """Write the name of every line next to its end, no two over each other."""
    axes.margins(x=0.02)
    wanted = [height_of_end(axes, line) for line in lines]
    for place, line, colour in zip(spread(wanted), lines, colours, strict=True):
        axes.annotate(line.label, (1.02, place), xycoords="axes fraction", color=colour, va="center")
    if heading:
        axes.annotate(heading, (1.02, 1.0), (0, 8), xycoords="axes fraction", textcoords="offset points")


def height_of_end(axes: Axes, line: Line) -> float:
    """Find where a line ends, over the height of the axes."""
    is_log = axes.get_yscale() == "log"
    along = line.x if isinstance(line.x, np.ndarray) else np.arange(len(line.x))
    drawn = np.isfinite(along) & np.isfinite(line.y) & ((line.y > 0) | (not is_log))
    if not drawn.any():
        return 0.0
    end = line.y[drawn][np.argmax(along[drawn])]
    low, high, end = (np.log if is_log else np.asarray)((*axes.get_ylim(), end))
    return float(np.clip((end - low) / (high - low), 0.0, 1.0))


def spread(wanted: Sequence[float]) -> list[float]:
    """Move places 0..1 apart until they keep their distance, in their order and as little as it takes."""
    order = np.argsort(wanted, kind="stable")
    steps = min(CLOSEST, 1.0 / max(len(order) - 1, 1)) * np.arange(len(order))
    places = np.empty(len(order))
    pushed_up = np.maximum.accumulate(np.asarray(wanted)[order] - steps)
    places[order] = np.minimum(pushed_up, 1.0 - steps[-1]) + steps
    return places.tolist()
