"""Shapes of hanging curls over weight and natural curvature, and the pitch along a helix."""

from pathlib import Path

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from hairpipe.graphs.experiments.chart.sheet import COLOURS, INK, sheet
from hairpipe.values import Table


def draw_curls(
    path: Path, shapes: Table, border: Table, pitches: Table, *, ratio: float, size: tuple[int, int]
) -> None:
    """Draw tables of `map_curls` and `measure_curls` in two charts, and write a PNG; ratio GJ / EI, size [px]."""
    with sheet(path, *size, (1, 2)) as (left, right):
        weight = shapes.numbers["weight"]
        curvature = shapes.numbers["curvature"]
        kinds = np.array(shapes.texts["shape"])
        flat = kinds == "planar"
        left.scatter(weight[flat], curvature[flat], 30, color="white", edgecolors=INK, linewidths=0.9, zorder=3)
        curled = shapes.numbers["curled [% of length]"][~flat]
        drawn = left.scatter(
            weight[~flat],
            curvature[~flat],
            44,
            c=curled,
            cmap="viridis_r",
            norm=Normalize(0, 100),
            marker="s",
            zorder=3,
        )
        left.figure.colorbar(drawn, ax=left, label="curled part of the strand [% of length]")
        order = np.lexsort((border.numbers["weight"], np.array(border.texts["kind"]) == "hook"))
        coils = [n for n in order[::-1] if border.texts["kind"][n] == "coil"]
        hooks = [n for n in order if border.texts["kind"][n] == "hook"]
        line = [*coils, *hooks]
        left.plot(border.numbers["weight"][line], border.numbers["curvature"][line], color=COLOURS[1])
        along = np.geomspace(0.8 * weight.min(), 1.25 * weight.max(), 100)
        full = np.sqrt(ratio * along)
        there = full > border.numbers["curvature"].min()
        left.plot(along[there], full[there], color=COLOURS[0], linestyle="--")
        left.set(
            xscale="log",
            yscale="log",
            xlim=(along[0], along[-1]),
            ylim=(0.8 * curvature.min(), 3.0 * curvature.max()),
            xlabel="weight, rho A g L³ / EI",
            ylabel="natural curvature times length",
            title="Shapes of a hanging arc",
        )
        left.set_yticks([2, 5, 10, 20])
        for axis in (left.xaxis, left.yaxis):
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        left.legend(
            handles=[
                Line2D([], [], marker="o", linestyle="", color="white", markeredgecolor=INK, label="strand, planar"),
                Line2D([], [], marker="s", linestyle="", color=INK, label="strand, helix"),
                Line2D([], [], color=COLOURS[1], label="theory: leaves its plane"),
                Line2D([], [], color=COLOURS[0], linestyle="--", label="theory: helix as long as the rod"),
            ],
            loc="upper left",
            fontsize=7,
        )
        arc = pitches.numbers["arc from the tip [% of length]"]
        right.plot(arc, pitches.numbers["theory"], color=COLOURS[1])
        right.plot(arc, pitches.numbers["pitch [% of length]"], "o", color=COLOURS[0])
        right.set(
            xlabel="arc from the tip [% of length]", ylabel="pitch [% of length]", title="Pitch along a long helix"
        )
        right.annotate("line: helix under the local tension\ndots: strand", (0.04, 0.86), xycoords="axes fraction")
