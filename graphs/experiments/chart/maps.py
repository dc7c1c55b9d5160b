"""Heat maps of an error over two parameters, a panel for every case, with failures written into the cells."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LogNorm
from matplotlib.patches import Rectangle

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.lines import check_columns
from hairpipe.graphs.experiments.chart.sheet import INK, sheet
from hairpipe.values import Table

COLOUR_MAP = "YlGnBu_r"
FAILED, NOT_RUN = "#d9482b", "not run"
FONT = 6.5
EXACT = 1e-6
"""How far one over a whole number may be off, over itself."""


@dataclass(frozen=True)
class MapColumns:
    """Columns of a table that maps are drawn from.

    panels  of texts: a panel for each
    x       of numbers, ascending to the right
    y       of texts, from the bottom up in the order of the table
    value   of numbers that colour the cells, on a logarithmic scale
    marks   of texts, several parted by commas: their first letters are written into a cell, which is red then; "not
            run" leaves it hatched
    """

    panels: str
    x: str
    y: str
    value: str
    marks: str


def draw_maps(
    path: Path,
    table: Table,
    columns: MapColumns,
    *,
    limits: tuple[float, float],
    across: int,
    title: str = "",
    size: tuple[int, int] = (2400, 1500),
) -> None:
    """Draw a cell for every row of a table, and write a PNG.

    limits  of the colours, more than 0 and ascending
    across  number of panels side by side

    Raises BadInput where there is no such column, or the limits do not ascend.
    """
    panels, x, y, value, marks = columns.panels, columns.x, columns.y, columns.value, columns.marks
    check_columns(table, [panels, x, y, value, marks], [x, value])
    if not 0.0 < limits[0] < limits[1]:
        raise BadInput(f"limits = {list(limits)}", right="a number above 0, and a larger one")
    names = list(dict.fromkeys(table[panels]))
    xs = sorted(set(table.numbers[x].tolist()))
    ys = list(dict.fromkeys(table[y]))
    norm = LogNorm(*limits, clip=True)
    colours = matplotlib.colormaps[COLOUR_MAP]
    rows = ceil(len(names) / across)
    signs: dict[str, str] = {}
    with sheet(path, *size, grid=(rows, across)) as axes:
        for place, name in zip(axes, names, strict=False):
            cells = [row for row, other in enumerate(table[panels]) if other == name]
            for row in cells:
                corner = xs.index(table[x][row]) - 0.5, ys.index(table[y][row]) - 0.5
                fill_cell(place, corner, float(table.numbers[value][row]), str(table[marks][row]), norm, colours, signs)
            frame_panel(place, name, xs, ys)
        for n, place in enumerate(axes):
            place.set_visible(n < len(names))
            if n % across:
                place.set_yticklabels([])
            if n + across >= len(names):
                place.set_xlabel(x)
        figure = axes[0].figure
        figure.colorbar(ScalarMappable(norm, colours), ax=axes, label=value, shrink=0.6, extend="both")
        legend = ", ".join(f"{sign} {text}" for sign, text in signs.items())
        figure.suptitle(f"{title}\nred, failed: {legend}; hatched: not run" if signs else title, x=0.01, ha="left")


def fill_cell(
    axes: Axes,
    corner: tuple[float, float],
    value: float,
    marks: str,
    norm: LogNorm,
    colours: Colormap,
    signs: dict[str, str],
) -> None:
    """Draw a cell of size 1, and note what its letters mean in signs, in place."""
    if marks == NOT_RUN:
        axes.add_patch(Rectangle(corner, 1, 1, facecolor="white", edgecolor="#aaaaaa", hatch="////", linewidth=0))
        return
    colour = FAILED if marks else colours(norm(value))
    axes.add_patch(Rectangle(corner, 1, 1, facecolor=colour, edgecolor="white", linewidth=0.8))
    parts = marks.split(", ") if marks else []
    signs |= {part[0].upper(): part for part in parts}
    text = "".join(part[0].upper() for part in parts) or shortest(value)
    pale = not marks and np.mean(colours(norm(value))[:3]) > 0.55
    centre = corner[0] + 0.5, corner[1] + 0.5
    axes.annotate(text, centre, ha="center", va="center", fontsize=FONT, color=INK if pale else "white")


def frame_panel(axes: Axes, name: str, xs: Sequence[float], ys: Sequence[str]) -> None:
    """Name a panel and its cells."""
    axes.set_title(name, fontsize=8)
    axes.set_xlim(-0.5, len(xs) - 0.5)
    axes.set_ylim(-0.5, len(ys) - 0.5)
    axes.set_xticks(range(len(xs)), [formatted(value) for value in xs], rotation=90, fontsize=FONT)
    axes.set_yticks(range(len(ys)), list(ys), fontsize=FONT + 0.5)
    axes.grid(False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def shortest(value: float) -> str:
    """Write a number in as little room as a cell has."""
    return "<.01" if value < 0.01 else f"{value:.0f}" if value >= 9.95 else f"{value:.2g}"


def formatted(value: float) -> str:
    """Write a step as people say it: one over a whole number where it is that and less than one."""
    if 0 < value < 1 and abs(value * round(1 / value) - 1) < EXACT:
        return f"1/{round(1 / value)}"
    return f"{value:g}"
