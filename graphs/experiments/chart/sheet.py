"""A sheet to draw on: one style for all charts, whatever the user's own settings, and the same bytes every time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

DPI = 150
INK, SOFT = "#222222", "#dddddd"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#7a5195", "#555555")
"""To tell apart, also without seeing red or green (after Okabe and Ito)."""
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#888888",
    "axes.linewidth": 0.6,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": SOFT,
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.4,
    "lines.markersize": 4,
}


@contextmanager
def sheet(path: Path, width: int, height: int, grid: tuple[int, int] = (1, 1)) -> Iterator[list[Axes]]:
    """Yield axes to draw on, row by row, and write them as PNG on leaving.

    width, height  of the picture [px]
    grid           rows and columns of axes
    """
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, layout="constrained")
        FigureCanvasAgg(figure)
        yield list(figure.subplots(*grid, squeeze=False).flat)
        figure.savefig(path, format="png", metadata={"Software": None})


def shades(count: int) -> list[Any]:
    """Pick colours for values in order, from early or small, dark, to late or large, light."""
    return list(matplotlib.colormaps["viridis"](np.linspace(0.0, 0.88, count)))
