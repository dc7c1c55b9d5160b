"""Strands over time: their poses at several moments, in one picture."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.sheet import INK, shades, sheet
from hairpipe.values import Strands

Plane = Literal["xy", "zy", "xz"]
PLANES: dict[str, tuple[int, int, int, float]] = {"xy": (0, 1, 2, 1.0), "zy": (2, 1, 0, -1.0), "xz": (0, 2, 1, -1.0)}
"""Coordinates to the right, upwards and towards the eye, and the sign of the last."""
OVERLAP = 0.4
"""Share of the next segment that is drawn with one, so that its rim does not cut the strand."""
TIMES = 32
"""Room for upright times above a drawing [points]."""
BAR = 0.25
"""Largest share of the width of the drawing that the scale bar takes."""


@dataclass(frozen=True)
class Pose:
    """Strands at a moment [s]: points of each, (n, 3) [m]."""

    time: float
    strands: list[np.ndarray]


@dataclass(frozen=True)
class Panel:
    """What is drawn side by side with others: a name and poses in the order of time."""

    name: str
    poses: list[Pose]


def panels_of(
    hair: Sequence[Mapping[int, Strands]],
    fps: float,
    count: int,
    moments: Sequence[int],
    strands: Sequence[int],
    cases: Sequence[str],
) -> list[Panel]:
    """Choose what to draw of simulations, the first frame at time zero; BadInput where strands or names do not fit.

    count    of frames, spread evenly
    moments  frames instead of those, as far as any are there
    strands  numbers of strands; all without
    cases    names of the simulations; none without
    """
    if cases and len(cases) != len(hair):
        raise BadInput(f"{len(cases)} names for {len(hair)} simulations", right="a name for each, or none")
    panels = []
    for name, shot in zip(cases or [""] * len(hair), hair, strict=True):
        frames = list(shot)
        spread = np.unique(np.linspace(0, len(frames) - 1, count).round().astype(int))
        chosen = [frame for frame in moments if frame in shot] or [frames[place] for place in spread]
        poses = [Pose((frame - frames[0]) / fps, curves(shot[frame], strands)) for frame in chosen]
        panels.append(Panel(name, poses))
    return panels


def curves(hair: Strands, strands: Sequence[int]) -> list[np.ndarray]:
    """Take the points of some strands, or of all; BadInput for one that is not there."""
    all_curves = [points.astype(float) for points in np.split(hair.points, hair.offsets[1:-1])]
    if any(not 0 <= strand < len(all_curves) for strand in strands):
        raise BadInput(f"strands = {list(strands)}", right=f"numbers from 0 to {len(all_curves) - 1}")
    return [all_curves[strand] for strand in strands] or all_curves


def draw_poses(
    path: Path,
    panels: Sequence[Panel],
    plane: Plane,
    apart: tuple[float, float] = (0.0, 0.0),
    title: str = "",
    size: tuple[int, int] = (1200, 750),
) -> None:
    """Draw all poses, coloured by time and to the same scale in all panels, and write a PNG.

    plane  which coordinates go right and up
    apart  how far every pose is drawn from the one before, to the right and up [m]; with the time next to it then
    size   of the picture [px]
    """
    times = sorted({pose.time for panel in panels for pose in panel.poses})
    colours = dict(zip(times, shades(len(times)), strict=True))
    boxes = [extent(panel, plane, apart) for panel in panels]
    room = np.max([high - low for low, high in boxes], axis=0)
    reach = float(room.max())
    is_row = abs(apart[0]) > abs(apart[1])
    with sheet(path, *size, grid_for(len(panels), room, size)) as places:
        row = places[: len(panels)]
        for axes in places[len(panels) :]:
            axes.remove()
        for axes, panel, (low, high) in zip(row, panels, boxes, strict=True):
            for number, pose in enumerate(panel.poses):
                shift = number * np.array(apart)
                draw_pose(axes, pose, plane, shift, colours[pose.time])
                if any(apart):
                    name_time(axes, pose, plane, shift, colours[pose.time], is_row)
            frame(axes, (low + high) / 2.0, room / 2.0 + 0.08 * reach)
            axes.set_title(panel.name, fontsize=9, pad=TIMES if is_row else 6)
        scale_bar(row[0], reach)
        row[0].figure.suptitle(title, x=0.01, ha="left", fontsize=11)
        if not any(apart) and len(times) > 1:
            time_bar(row, times)


def extent(panel: Panel, plane: Plane, apart: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Find the corners of all that is drawn in a panel [m]."""
    flat = [
        points[:, PLANES[plane][:2]] + number * np.array(apart)
        for number, pose in enumerate(panel.poses)
        for points in pose.strands
    ]
    drawn = np.concatenate(flat)
    return drawn.min(axis=0), drawn.max(axis=0)


def draw_pose(axes: Axes, pose: Pose, plane: Plane, shift: np.ndarray, colour: Any) -> None:
    """Draw strands from back to front, each piece with a light rim, so that crossings show what is above."""
    right, up, depth, sign = PLANES[plane]
    pieces = np.concatenate([pieces_of(points) for points in pose.strands])
    order = np.argsort(sign * pieces[:, 1:3, depth].mean(axis=1), kind="stable")
    flat = pieces[order][:, :, [right, up]] + shift
    lines = [line for piece in flat for line in (piece[1:3], piece)]
    drawn = LineCollection(lines, linewidths=[3.2, 1.6] * len(flat), colors=["white", colour] * len(flat))
    drawn.set_capstyle("butt")
    axes.add_collection(drawn)
    for points in pose.strands:
        axes.plot(*(points[0, [right, up]] + shift), "o", color=colour, markersize=3.5)


def pieces_of(points: np.ndarray) -> np.ndarray:
    """Cut a curve, (n, 3), into its segments, each with a bit of those before and after it, (n - 1, 4, 3)."""
    start, end = points[:-1], points[1:]
    before, after = (np.concatenate(p) for p in ((start[:1], start[:-1]), (end[1:], end[-1:])))
    return np.stack([start + OVERLAP * (before - start), start, end, end + OVERLAP * (after - end)], axis=1)


def name_time(axes: Axes, pose: Pose, plane: Plane, shift: np.ndarray, colour: Any, is_row: bool) -> None:
    """Write the time of a pose next to its root, or upwards above it where poses stand in a row."""
    right, up = PLANES[plane][:2]
    root = pose.strands[0][0, [right, up]]
    top = max(points[:, up].max() for points in pose.strands) if is_row else root[1]
    offset = (0, 5) if is_row else (-5, 0)
    text = axes.annotate(
        f"{pose.time:.2f} s", (root[0] + shift[0], top + shift[1]), offset, textcoords="offset points", color=colour
    )
    text.set(rotation=90 if is_row else 0, ha="center" if is_row else "right", va="bottom" if is_row else "center")


def frame(axes: Axes, middle: np.ndarray, half: np.ndarray) -> None:
    """Set limits around a middle, with equal scales, and take the axes away: a bar tells the scale."""
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] - half[1], middle[1] + half[1]))
    axes.set_aspect("equal")
    axes.set_axis_off()


def grid_for(panels: int, room: np.ndarray, size: tuple[int, int]) -> tuple[int, int]:
    """Choose rows and columns of panels so that what is in them, of equal room, (2,) [m], is drawn largest."""

    def scale(rows: int) -> float:
        columns = -(-panels // rows)
        return min(size[0] / (columns * max(room[0], 1e-9)), size[1] / (rows * max(room[1], 1e-9)))

    rows = max(range(1, panels + 1), key=scale)
    return rows, -(-panels // rows)


def scale_bar(axes: Axes, reach: float) -> None:
    """Draw a bar of a round length below the drawing."""
    decade = 10.0 ** np.floor(np.log10(BAR * reach))
    length = max(step * decade for step in (1, 2, 5) if step * decade <= BAR * reach)
    left = axes.get_xlim()[0]
    bottom = axes.get_ylim()[0]
    axes.plot([left, left + length], [bottom, bottom], color=INK, linewidth=2, clip_on=False, solid_capstyle="butt")
    text = f"{length:g} m" if length >= 0.5 else f"{100 * length:g} cm" if length >= 0.01 else f"{1e3 * length:g} mm"
    axes.annotate(text, (left, bottom), (0, 3), textcoords="offset points", va="bottom", annotation_clip=False)


def time_bar(row: list[Axes], times: Sequence[float]) -> None:
    """Show which colour is which time."""
    norm = Normalize(times[0], times[-1])
    colours = ScalarMappable(norm, ListedColormap(shades(256)))
    row[0].figure.colorbar(colours, ax=row, label="time [s]", shrink=0.6, aspect=30)
