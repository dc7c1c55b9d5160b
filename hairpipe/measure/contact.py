"""Contact of hair with bodies: penetration depth, speed and stretch."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hairpipe.data import BodyParts, LevelSet, Strands, Table
from hairpipe.data.lengths import segment_lengths
from hairpipe.data.table import table_of_rows
from hairpipe.levelset.collider import Collider, SdfSample
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.interpolation import Interpolation
from hairpipe.levelset.parts.collider_parts import build_collider_parts
from hairpipe.measure.pinching import is_pinched

COLUMNS = (
    "time [s]",
    "deepest [mm]",
    "99 % quantile [mm]",
    "points inside",
    "points",
    "still inside [mm]",
    "points still inside",
    "pinched [mm]",
    "points pinched",
    "fastest point [m/s]",
    "segment stretch [%]",
)


def measure_contacts(
    hair: Mapping[int, Strands],
    surfaces: Sequence[Mapping[int, LevelSet]],
    parts: Sequence[Mapping[int, BodyParts]],
    fps: float,
) -> Table:
    """Return a row for every frame, over all points but the roots, which the body holds; time zero is the first frame.

    surfaces, parts  level sets of the bodies; the depth of a point is the largest in any body
    deepest          largest depth, 0 where all points are outside
    99 % quantile    of the depth of points
    still inside     strands that began inside and have not been outside as a whole since; excluded elsewhere
    pinched          points between bodies without free space (`pinching.py`); excluded elsewhere
    segment stretch  largest stretch, over the length in the first frame
    """
    frames = list(hair)
    rest = segment_lengths(hair[frames[0]].points, hair[frames[0]].offsets)
    rest[rest == 0.0] = np.inf
    rows: list[tuple[Any, ...]] = []
    late_strands: np.ndarray | None = None
    counts = np.diff(hair[frames[0]].offsets) - 1
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    for frame in frames:
        bodies = [still(surface[frame]) for surface in surfaces] + [still_parts(part[frame]) for part in parts]
        depth = depths(hair[frame], bodies)
        inside = np.add.reduceat(depth > 0.0, starts) > 0
        late_strands = inside if late_strands is None else late_strands & inside
        begun = np.repeat(late_strands, counts) & (depth > 0.0)
        pinched = np.zeros_like(begun)
        others = np.flatnonzero((depth > 0.0) & ~begun)
        pinched[others] = is_pinched(free_points(hair[frame])[others], depth[others], bodies)
        missed = np.where(begun | pinched, 0.0, depth)
        deep = (1e3 * missed.max(initial=0.0), 1e3 * np.percentile(missed, 99.0) if len(missed) else 0.0)
        deep = (*deep, np.count_nonzero(missed), len(depth))
        left = (1e3 * depth[begun].max(initial=0.0), np.count_nonzero(begun))
        left = (*left, 1e3 * depth[pinched].max(initial=0.0), np.count_nonzero(pinched))
        moving = np.delete(hair[frame].velocities.astype(float), hair[frame].offsets[:-1], axis=0)
        speed = np.linalg.norm(moving, axis=1).max(initial=0.0)
        stretch = 100.0 * (segment_lengths(hair[frame].points, hair[frame].offsets) / rest - 1.0).max(initial=-1.0)
        rows.append(((frame - frames[0]) / fps, *deep, *left, speed, stretch))
    return table_of_rows(COLUMNS, rows)


def still(surface: LevelSet) -> Collider:
    """Make the collider of a body at rest."""
    return build_collider_field(surface, surface, 1.0, Interpolation.linear)


def still_parts(parts: BodyParts) -> Collider:
    """Make the collider of a body in parts, at rest in the pose of a frame."""
    return build_collider_parts(parts, parts, 1.0)


def depths(hair: Strands, bodies: Sequence[Collider]) -> np.ndarray:
    """Return the depth of all points but the roots inside the union of bodies [m], (P - S,); 0 outside."""
    free = free_points(hair)
    probe = SdfSample.blank(len(free), 0.0)
    for body in bodies:
        body.probe(free, 0.0, probe)
    return 0.0 - probe.distance


def free_points(hair: Strands) -> np.ndarray:
    """Return all points but the roots [m], (P - S, 3)."""
    return np.delete(hair.points.astype(float), hair.offsets[:-1], axis=0)
