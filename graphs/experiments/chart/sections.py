"""Sections through level sets: rows of panels, each with what is inside, and with the true outline."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from hairpipe.graphs.experiments.chart.sheet import COLOURS, INK, sheet
from hairpipe.values import Density

SOLID = "#a9cbe4"
RIGHT = COLOURS[1]
LINES = 5
"""Lines of equal distance outside, up to the farthest that is shown."""


def draw_sections(
    path: Path,
    rows: Mapping[str, Sequence[np.ndarray]],
    truth: Sequence[np.ndarray],
    columns: Sequence[str],
    extent: tuple[float, float, float, float],
    *,
    reach: float,
    title: str = "",
    size: tuple[int, int] = (1800, 1200),
) -> None:
    """Draw a row of panels by name, one for every column, and write a PNG.

    rows    signed distances [m], (height, width) each, negative inside; +inf where unknown
    truth   of every column
    extent  left, right, bottom and top of the panels [m]
    reach   farthest distance that is drawn [m]
    """
    with sheet(path, *size, grid=(len(rows), len(columns))) as axes:
        for line, (name, panels) in enumerate(rows.items()):
            for place, panel in enumerate(panels):
                here = axes[line * len(columns) + place]
                draw_panel(here, panel, truth[place], extent, reach)
                here.set_title(columns[place] if line == 0 else "", fontsize=9)
            axes[line * len(columns)].set_ylabel(name, fontsize=11)
        axes[0].figure.suptitle(title, x=0.01, ha="left")


def draw_panel(
    axes: Axes, distance: np.ndarray, truth: np.ndarray, extent: tuple[float, float, float, float], reach: float
) -> None:
    """Draw one section: the body filled, lines of equal distance around it, and the true outline."""
    x, y = np.linspace(*extent[:2], distance.shape[1]), np.linspace(*extent[2:], distance.shape[0])
    shown, right = (np.clip(values, -reach, reach) for values in (distance, truth))
    axes.contourf(x, y, shown, levels=[-2.0 * reach, 0.0], colors=[SOLID])
    if shown.min() < 0.0 < shown.max():
        axes.contour(x, y, shown, levels=[0.0], colors=[INK], linewidths=1.2)
    axes.contour(x, y, shown, levels=reach * np.arange(1, LINES) / LINES, colors=["#bbbbbb"], linewidths=0.5)
    axes.contour(x, y, right, levels=[0.0], colors=[RIGHT], linewidths=1.1, linestyles="dashed")
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)


def section_of(density: Density, axis: int, place: float) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """Cut a density across an axis at a place [m], linear between nodes.

    Returns the length of hair per volume [m/m^3], (n, m), the first of the other axes to the right (z of y is), the
    second upwards, and left, right, bottom and top [m] of the nodes.
    """
    across, up = {0: (2, 1), 1: (0, 2), 2: (0, 1)}[axis]
    u = place / density.cell - density.low[axis]
    planes = np.moveaxis(density.length, (axis, up, across), (0, 1, 2)).astype(float)
    i = int(np.floor(u))
    share = u - np.floor(u)
    found = np.zeros(planes.shape[1:])
    for plane, weight in ((i, 1.0 - share), (i + 1, share)):
        if 0 <= plane < len(planes):
            found += weight * planes[plane]
    low, cell = density.low, density.cell
    ends = [cell * end for a in (across, up) for end in (low[a], low[a] + density.length.shape[a] - 1)]
    return found, (ends[0], ends[1], ends[2], ends[3])
