"""Placement of labels next to points, so that they overlap each other and the points as little as possible."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hairpipe.graphs.experiments.chart.sheet import DPI

FONT, WIDTH, HEIGHT = 7.0, 0.56, 1.25
"""Size of letters [pt]; width of a letter and height of a line, over that size."""
RINGS = (7.0, 14.0, 24.0, 38.0, 56.0)
"""Distances from a point to its name that are tried [pt]; from the third on a line joins them."""
ANGLES = 16
POINT = 5.0
"""Half the size of a point that is not to be hidden [pt]."""


class Label(NamedTuple):
    """A text, the point that it names in the coordinates of the axes, and its colour."""

    text: str
    point: tuple[float, float]
    colour: str


class Box(NamedTuple):
    """A rectangle [pt]."""

    left: float
    low: float
    right: float
    high: float

    def overlap(self, other: "Box") -> float:
        """Return the area that two have in common [pt^2]."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        tall = min(self.high, other.high) - max(self.low, other.low)
        return max(wide, 0.0) * max(tall, 0.0)


def place_labels(axes: Axes, labels: Sequence[Label]) -> None:
    """Write labels, the ones in a crowd last, each where least is hidden and as near to its point as that allows.

    Limits and scales of the axes are set.
    """
    if isinstance(axes.figure, Figure):
        axes.figure.draw_without_rendering()  # lays the axes out
    scale = 72.0 / DPI
    points = axes.transData.transform([label.point for label in labels]) * scale if labels else np.empty((0, 2))
    frame = axes.get_window_extent()
    inside = Box(frame.x0 * scale, frame.y0 * scale, frame.x1 * scale, frame.y1 * scale)
    taken = [Box(x - POINT, y - POINT, x + POINT, y + POINT) for x, y in points]
    crowd = [np.sum(np.hypot(*(points - point).T) < RINGS[-1]) for point in points]
    for n in np.argsort(crowd, kind="stable"):
        label, point = labels[n], points[n]
        others = taken[:n] + taken[n + 1 :]
        choices = list(candidates(label.text, point, inside))
        hidden = [sum(box.overlap(other) for other in others) + far for box, far in choices]
        box, _ = choices[int(np.argmin(hidden))]
        taken.append(box)
        write(axes, label, point, box)


def candidates(text: str, point: np.ndarray, inside: Box) -> Iterator[tuple[Box, float]]:
    """List where a text may stand next to a point [pt], and what its distance and what leaves the axes count for."""
    wide = WIDTH * FONT * len(text)
    tall = HEIGHT * FONT
    for ring, distance in enumerate(RINGS):
        for turn in range(ANGLES):
            angle = 2.0 * np.pi * turn / ANGLES
            x, y = point + distance * np.array([np.cos(angle), np.sin(angle)])
            left = x - wide * (0.5 - 0.5 * np.cos(angle))
            low = y - tall * (0.5 - 0.5 * np.sin(angle))
            box = Box(left, low, left + wide, low + tall)
            outside = wide * tall - box.overlap(inside)
            yield box, 4.0 * ring**2 + 10.0 * outside


def write(axes: Axes, label: Label, point: np.ndarray, box: Box) -> None:
    """Write a label into its box, with a line to its point where that is far."""
    middle = np.array([0.5 * (box.left + box.right), 0.5 * (box.low + box.high)])
    nearest = np.clip(point, [box.left, box.low], [box.right, box.high])
    line = {"arrowstyle": "-", "color": label.colour, "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 3.0, "alpha": 0.7}
    far = np.hypot(*(nearest - point)) > RINGS[1]
    written = axes.annotate(
        label.text,
        label.point,
        tuple(middle - point),
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=FONT,
        color=label.colour,
        arrowprops=line if far else None,
        annotation_clip=False,
        zorder=6,
    )
    written.set_in_layout(False)
