"""Strands over time as a table."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hairpipe.graphs.experiments.measure.writhe import writhe
from hairpipe.values import Ends, Strands, Table
from hairpipe.values.table import table_of_rows

COLUMNS = (
    "time [s]",
    "strand",
    "tip x [m]",
    "tip y [m]",
    "tip z [m]",
    "span [m]",
    "bulge [m]",
    "stretch [%]",
    "segment strain [%]",
    "fastest point [m/s]",
    "writhe [1]",
    "moved [mm]",
)
TURNED = "turned [rad]"


def measure(hair: Mapping[int, Strands], fps: float, ends: Mapping[int, Ends] | None = None) -> Table:
    """Return a row for every frame and strand, compared with the first frame, which is time zero.

    span            from root to tip
    bulge           largest distance from the line between root and tip
    stretch         of the whole strand
    segment strain  largest absolute strain
    writhe          loops, see `writhe`
    moved           root mean square displacement of the points
    turned          rotation of the tip against the root, about the initial line between them; with scripted ends
    """
    frames = list(hair)
    first = hair[frames[0]]
    rows = [row for frame in frames for row in rows_of(hair[frame], first, (frame - frames[0]) / fps)]
    if ends is None:
        return table_of_rows(COLUMNS, rows)
    along = first.points[first.offsets[1:] - 1] - first.points[first.offsets[:-1]]
    along = np.einsum("sji,sj->si", ends[frames[0]].roots[:, :, :3], along)
    angles = turns([ends[frame] for frame in frames], along)
    return table_of_rows((*COLUMNS, TURNED), [(*row, angle) for row, angle in zip(rows, angles.ravel(), strict=True)])


def rows_of(now: Strands, first: Strands, time: float) -> Iterator[tuple[Any, ...]]:
    """Measure every strand at one frame."""
    for strand, (begin, end) in enumerate(zip(now.offsets, now.offsets[1:], strict=False)):
        points, before = (hair.points[begin:end].astype(float) for hair in (now, first))
        lengths, rest = (np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (points, before))
        yield (
            time,
            strand,
            *points[-1].tolist(),
            np.linalg.norm(points[-1] - points[0]),
            bulge(points),
            100.0 * (lengths.sum() / rest.sum() - 1.0),
            100.0 * np.abs(lengths / rest - 1.0).max(),
            np.linalg.norm(now.velocities[begin:end], axis=1).max(),
            writhe(points),
            1e3 * np.sqrt(np.mean(np.sum((points - before) ** 2, axis=1))),
        )


def bulge(points: np.ndarray) -> float:
    """Return the largest distance of a curve, (n, 3), from the line between its ends."""
    line = points[-1] - points[0]
    length = np.linalg.norm(line)
    along = line / length if length > 0.0 else line
    away = points - points[0]
    return float(np.linalg.norm(away - np.outer(away @ along, along), axis=1).max())


def turns(ends: Sequence[Ends], along: np.ndarray) -> np.ndarray:
    """Sum the rotations of the tips relative to the roots [rad], (frames, S); less than half a turn per frame.

    along  axis of every strand in the groom, (S, 3), of any length
    """
    axes = along / np.linalg.norm(along, axis=1, keepdims=True)
    against = np.array([np.einsum("sji,sjk->sik", e.roots[:, :, :3], e.tips[:, :, :3]) for e in ends])
    steps = np.einsum("fsik,fsjk->fsij", against, np.concatenate([against[:1], against[:-1]]))
    twice = np.stack([steps[..., k - 1, k - 2] - steps[..., k - 2, k - 1] for k in range(3)], axis=-1)
    sines = 0.5 * np.einsum("fsk,sk->fs", twice, axes)
    cosines = 0.5 * (np.trace(steps, axis1=2, axis2=3) - 1.0)
    return np.cumsum(np.arctan2(sines, cosines), axis=0)
