"""Sections through densities of hair, side by side, with one scale of colours."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from hairpipe.graphs.experiments.chart.sheet import sheet

COLOUR_MAP = "magma_r"

Panel = tuple[str, np.ndarray, tuple[float, float, float, float]]
"""A name, length of hair per volume [m/m^3], (n, m), upwards, and left, right, bottom and top of its nodes [m]."""


def draw_densities(
    path: Path, panels: Sequence[Panel], *, title: str = "", size: tuple[int, int] = (1200, 600)
) -> None:
    """Draw sections on one scale of lengths, all of the same room, and write a PNG."""
    most = max((float(values.max(initial=0.0)) for _, values, _ in panels), default=0.0)
    scale = Normalize(0.0, most or 1.0)
    ends = np.array([extent for _, values, extent in panels if values.size] or [(0.0, 1.0, 0.0, 1.0)])
    room = ends[:, 0].min(), ends[:, 1].max(), ends[:, 2].min(), ends[:, 3].max()
    with sheet(path, *size, grid=(1, len(panels))) as axes:
        for here, (name, values, extent) in zip(axes, panels, strict=True):
            if values.size:
                edges = widened(extent, values.shape)
                here.imshow(values, norm=scale, cmap=COLOUR_MAP, origin="lower", extent=edges, interpolation="bilinear")
            here.set(xlim=room[:2], ylim=room[2:], aspect="equal", xlabel="m", title=name)
            here.grid(visible=False)
        axes[0].set_ylabel("m")
        axes[0].figure.colorbar(
            ScalarMappable(scale, COLOUR_MAP), ax=list(axes), label="hair per volume [m/m³]", shrink=0.8
        )
        axes[0].figure.suptitle(title, x=0.01, ha="left")


def widened(extent: tuple[float, float, float, float], shape: tuple[int, ...]) -> tuple[float, float, float, float]:
    """Return the edges of an image whose pixels have their centres at nodes: half a cell beyond the outer ones."""
    left, right, bottom, top = extent
    x, y = (0.5 * (b - a) / (n - 1) for a, b, n in ((left, right, shape[1]), (bottom, top, shape[0])))
    return left - x, right + x, bottom - y, top + y
