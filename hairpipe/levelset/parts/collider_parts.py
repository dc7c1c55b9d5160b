"""A body in parts between two frames: each part moves along its bone's path, with a blended shape.

    phi(x, a) = min_k f_k(R_k(a)^T (x - p_k(a)), a),   f_k(X, a) = (1 - a) phi_k0(X) + a phi_k1(X)
    v = dp/dt + omega x (x - p) + u n,   u = (phi_k0 - phi_k1) / (dt |grad f_k|)

with the path of `pose_path`. A part of constant shape is read once.

We differ from the paper (Selle et al. 2008, section 5), which blends one level set of the whole body along its mean
velocity: this needs no velocities, preserves the shape of rotating parts, and does not mix two close bodies.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from hairpipe.data import BodyParts
from hairpipe.errors import BadInput
from hairpipe.levelset.collider import FirstHit, SdfSample, Walk
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.levelset.parts.field import PartField, part_field_of
from hairpipe.levelset.parts.pose_path import PartPoses, PosePath, part_poses_at, path_between
from hairpipe.levelset.parts.probe import Places, probe_parts
from hairpipe.levelset.parts.shape import largest_changes
from hairpipe.levelset.parts.sweep import Outlines, sweep_parts

# A part turns by no more than this from a sample of its pose to the next [rad], between which its points move straight.
FINE = 0.02
MOST_LOOKS = 64
_LOOKS = 5
"""Samples of a frame in which its fastest moment is looked for."""


@dataclass(frozen=True, eq=False)
class ColliderParts:
    """A body in parts between two frames; a Collider.

    before, after  the parts at the two frames
    outlines       outlines of the parts in their own frames
    path           path of the poses
    """

    before: PartField
    after: PartField
    outlines: Outlines
    path: PosePath

    @property
    def speed(self) -> float:
        """Return an upper bound of the speed of parts [m/s]: of the fastest corner of a box, plus that of its shape.

        The corners are sampled at a few times, v + omega x (x - p).
        """
        return self._speed

    @cached_property
    def _speed(self) -> float:
        part_poses = part_poses_at(self.path, np.linspace(0.0, self.path.frame, _LOOKS))
        corners = np.stack(np.meshgrid(*3 * [[False, True]], indexing="ij"), axis=-1).reshape(-1, 3)
        arms = np.einsum(
            "tkxy,cky->ctkx", part_poses.turns, np.where(corners[:, None], self.outlines.high, self.outlines.low)
        )
        advected = np.linalg.norm(part_poses.drifts + np.cross(part_poses.spins, arms), axis=-1)
        return float((advected + self.swelling).max(initial=0.0))

    @cached_property
    def swelling(self) -> np.ndarray:
        """Speed of the shape of every part in its own frame [m/s], |phi_1 - phi_0| / dt where that is largest, (G,)."""
        return largest_changes(self.before, self.after, self.outlines.changes) / self.path.frame

    @property
    def band(self) -> float:
        """Distance beyond which the body is not found [m]."""
        return self.before.background

    def probe(self, points: np.ndarray, seconds: float, out: SdfSample, reach: np.ndarray | None = None) -> None:
        """Write what is nearer than out, in place; see Collider."""
        reach = np.full(len(points), np.inf) if reach is None else reach
        part_poses = part_poses_at(self.path, np.array([seconds]))
        parts = Places(self.outlines.changes, boxes_at(part_poses, self.outlines), self.path.frame, reach)
        probe_parts(self.before, self.after, part_poses, parts, points, *out)

    def sweep(self, walk: Walk, start: float, end: float, out: FirstHit) -> None:
        """Write hits that are sooner than out, in place; see Collider."""
        part_poses = part_poses_at(self.path, self.looks(start, end))
        boxes = boxes_at(part_poses, self.outlines)
        farthest = self.speed * (end - start)
        sweep_parts(self.before, self.after, self.outlines, part_poses, boxes, walk, farthest, out.fraction)

    def looks(self, start: float, end: float) -> np.ndarray:
        """Return even times from start to end [s] between which no part turns much, (T,)."""
        spins = part_poses_at(self.path, np.array([start, 0.5 * (start + end), end])).spins
        turn = np.sqrt((spins**2).sum(axis=2)).max() * (end - start)
        return np.linspace(start, end, 1 + min(MOST_LOOKS, 1 + int(turn / FINE)))


def build_collider_parts(before: BodyParts, after: BodyParts, frame: float) -> ColliderParts:
    """Build a body that moves from one frame to the next; shares the arrays.

    frame  time between them [s]

    Raises BadInput if the frames have different parts.
    """
    if before.names != after.names or before.voxel != after.voxel or before.half_width != after.half_width:
        right = "parts baked from one body with the same settings"
        raise BadInput("the parts of the body are not the same at both frames", where="parts", right=right)
    low = np.minimum(before.origins, after.origins)
    highs = [parts.origins + BRICK * parts.voxel * parts.shapes for parts in (before, after)]
    path = path_between(before.poses, before.rates, after.poses, after.rates, frame)
    changes = np.array([not is_same(before, after, part) for part in range(len(before.names))])
    outlines = Outlines(changes, low, np.maximum(*highs))
    return ColliderParts(part_field_of(before), part_field_of(after), outlines, path)


def is_same(before: BodyParts, after: BodyParts, part: int) -> bool:
    """Return whether a part has the same samples in both frames."""
    if not np.array_equal(before.origins[part], after.origins[part]):
        return False
    if not np.array_equal(before.shapes[part], after.shapes[part]):
        return False
    (b0, d0), (b1, d1) = (samples_of(parts, part) for parts in (before, after))
    return np.array_equal(b0, b1) and np.array_equal(d0, d1)


def samples_of(parts: BodyParts, part: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of a part's bricks, counted from its first, and their samples."""
    index = parts.bricks[parts.starts[part] : parts.starts[part + 1]]
    count = int((index >= 0).sum())
    first = int(index[index >= 0].min()) if count else 0
    return np.where(index >= 0, index - first, index), parts.distance[first : first + count]


@njit(cache=True)
def boxes_at(part_poses: PartPoses, outlines: Outlines) -> np.ndarray:
    """Return low and high corner, in the world, of the box around every part at all times together [m], (G, 2, 3)."""
    low, high = outlines.low, outlines.high
    boxes = np.empty((len(low), 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for t in range(len(part_poses.turns)):
        for k in range(len(low)):
            for x in range(3):
                middle = part_poses.places[t, k, x]
                half = 0.0
                for y in range(3):
                    turn = part_poses.turns[t, k, x, y]
                    middle += 0.5 * turn * (low[k, y] + high[k, y])
                    # The box around a turned box: its half edges are those of the part times |R|.
                    half += 0.5 * abs(turn) * (high[k, y] - low[k, y])
                boxes[k, 0, x] = min(boxes[k, 0, x], middle - half)
                boxes[k, 1, x] = max(boxes[k, 1, x], middle + half)
    return boxes
