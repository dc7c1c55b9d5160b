"""Tables of the tension along strands."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.measure.motion import layout_of, tensions
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

COLUMNS = ("time [s]", "strand", "segment", "root moved [mm]", "arc [m]", "turned [deg]", "tension [uN]")


def measure_tensions(groom: Groom, states: Mapping[int, HairState], fps: float, moments: Sequence[int]) -> Table:
    """Return a row for every segment of every strand at every frame; time zero is the first frame.

    moments     frames that are measured; all if none of them is among the frames
    root moved  displacement of the root since the first frame
    arc         from the root to the middle of the segment
    turned      rotation of the strand since its root, about its mean axis of rotation
    tension     see `tensions`
    """
    frames = list(states)
    first = layout_of(groom, states[frames[0]]).axis(states[frames[0]].positions)[groom.offsets[:-1]]
    rows: list[tuple[Any, ...]] = []
    for frame in [f for f in frames if f in moments] or frames:
        layout = layout_of(groom, states[frame])
        for strand, points, pulls in tensions(layout, states[frame]):
            lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
            middles = np.cumsum(lengths) - 0.5 * lengths
            columns = zip(middles.tolist(), turns(points).tolist(), (1e6 * pulls).tolist(), strict=True)
            moved = 1e3 * float(np.linalg.norm(points[0] - first[strand]))
            rows += [((frame - frames[0]) / fps, strand, k, moved, *values) for k, values in enumerate(columns)]
    rows.sort(key=lambda row: row[:3])
    return table_of_rows(COLUMNS, rows)


def first_strand(groom: Groom, state: HairState) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of strand 0 [m], (n+1, 3), and the tension of its segments [N], (n,)."""
    found = tensions(layout_of(groom, state), state)
    return next((points, pulls) for strand, points, pulls in found if strand == 0)


def frames_between(frames: Sequence[int], fps: float, window: tuple[float, float]) -> list[tuple[int, float]]:
    """Return the frames of a window of time, each with its time, the first frame being time zero [s].

    BadInput where there is none.
    """
    times = [(frame, (frame - frames[0]) / fps) for frame in frames]
    found = [(frame, time) for frame, time in times if window[0] <= time <= window[1]]
    if not found:
        raise BadInput(f"no frame from {window[0]:g} to {window[1]:g} s", right="times of the run")
    return found


def turns(points: np.ndarray) -> np.ndarray:
    """Return the angle of every segment of a curve, (n+1, 3), relative to the first [deg], (n,).

    Angles between neighbours are measured about the mean of their axes, so that oscillations cancel.
    """
    edges = np.diff(points, axis=0)
    across = np.cross(edges[:-1], edges[1:])
    cosines = np.sum(edges[:-1] * edges[1:], axis=1)
    axis = across.sum(axis=0)
    size = np.linalg.norm(axis)
    sines = across @ (axis / size if size > 0.0 else axis)
    return np.degrees(np.cumsum([0.0, *np.arctan2(sines, cosines)]))
