"""Boundary conditions of strands between two frames: held particles at the root and at a held tip.

The clamp is rigid in the frame of the root's triangle, or of the scripted ends. Between frames it moves on the cubic
through both positions and velocities, so that its speed is continuous at frames.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import root_frames
from hairpipe.strands.layout import Layout
from hairpipe.values import Ends, Groom, Mesh
from hairpipe.values.groom import Driver, check_driver
from hairpipe.values.strand_arrays import FREE, name_strands

B = TypeVar("B")
E = TypeVar("E")
WORLD = np.zeros(3)
"""The origin of the world [m]."""
_INSTANT = 1e-5  # [s]; velocities of root frames are differences over this time, the body moving in a straight line


@dataclass(frozen=True, eq=False)
class Clamp:
    """Held particles at one frame: those at the root, then those at the tip, even of a free tip.

    positions  [m], (blocks, 2 clamped, 3, W)
    velocities [m/s], same shape
    tips       1 if the tip is held, (blocks, W); no rows if all are free
    """

    positions: np.ndarray
    velocities: np.ndarray
    tips: np.ndarray


@dataclass(frozen=True, eq=False)
class ClampPath:
    """The way of held particles between two frames; frame_dt is the time between them [s]."""

    start: Clamp
    end: Clamp
    frame_dt: float

    def ends(self, time: float) -> np.ndarray:
        """Find them at a time since the start [s], on the cubic Hermite curve [m], (blocks, 2 clamped, 3, W)."""
        s = time / self.frame_dt
        found = (
            (1 + 2 * s) * (1 - s) ** 2 * self.start.positions
            + s * (1 - s) ** 2 * self.frame_dt * self.start.velocities
            + s**2 * (3 - 2 * s) * self.end.positions
            + s**2 * (s - 1) * self.frame_dt * self.end.velocities
        )
        return found.astype(self.start.positions.dtype, copy=False)

    def way(self, here: np.ndarray, time: float) -> np.ndarray:
        """Find how far held particles are from here at a time [s], 0 where they are free [m]; shapes as `ends`."""
        way = self.ends(time) - here
        clamped = here.shape[1] // 2
        way[:, clamped:] *= self.held[:, None, None] if len(self.held) else 0.0
        return way

    @property
    def held(self) -> np.ndarray:
        """Tips that are held through the frame: held at both ends of it."""
        both = min(len(self.start.tips), len(self.end.tips))
        return self.start.tips[:both] * self.end.tips[:both]


def origin_of(x: np.ndarray, layout: Layout) -> np.ndarray:
    """Return the middle of the roots of strands [m], (3,), about which a frame is computed; x [m], (rows, 3, W).

    This makes the precision independent of the distance from the world's origin. Non-finite roots are excluded.
    """
    roots = layout.axis(x)[layout.offsets[:-1]]
    roots = roots[np.isfinite(roots).all(axis=1)]
    return roots.mean(axis=0) if len(roots) else WORLD


def about(origin: np.ndarray, x: np.ndarray, layout: Layout) -> np.ndarray:
    """Return x [m], (..., 3, W) float64, about an origin, in the precision that strands are computed in."""
    return (x - origin[:, None]).astype(layout.dtype)


def driver_of(body: B | None, ends: E | None) -> B | E | None:
    """Choose the driver of the roots, a body or ends; None: the roots are fixed. BadInput where both are given."""
    if body is not None and ends is not None:
        raise BadInput("both a body and driven ends move the roots", right="in.body or in.ends")
    return ends if body is None else body


def _from_rest(frames: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Rigid motion that takes the rest frame of every end to the given one: x -> R x + t, (strands, 3, 4)."""
    turn = np.einsum("sij,skj->sik", frames[:, :, :3], rest[:, :, :3])
    shift = frames[:, :, 3] - np.einsum("sij,sj->si", turn, rest[:, :, 3])
    return np.concatenate([turn, shift[:, :, None]], axis=2)


def motion_of_sites(
    mesh: Mesh | None, triangles: np.ndarray, barycentrics: np.ndarray, rest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return rigid motions of sites of a body from their rest frames, and their rates, (k, 3, 4) each; pure.

    triangles, barycentrics  of the sites, (k,) and (k, 3)
    rest                     their frames at rest, (k, 3, 4); without a body nothing moves
    """
    if mesh is None:
        still = np.tile(np.eye(3, 4), (len(triangles), 1, 1))
        return still, np.zeros_like(still)
    corners = mesh.triangles[triangles].ravel()  # of the few triangles that hold ends
    points = mesh.points[corners]
    ahead = _INSTANT * mesh.rates[corners]
    own = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    each = np.arange(len(triangles), dtype=np.int32)
    before, now, after = (
        _from_rest(root_frames(points + way * ahead, own, each, barycentrics), rest) for way in (-1.0, 0.0, 1.0)
    )
    return now, (after - before) / (2 * _INSTANT)


def motion_of_roots(driver: Driver, groom: Groom) -> tuple[np.ndarray, np.ndarray]:
    """Return rigid motions of the roots from the groom, and their rates, (strands, 3, 4).

    Raises BadInput if the driver belongs to another groom.
    """
    check_driver(driver, groom)
    if isinstance(driver, Ends):
        return driver.roots, driver.roots_rate
    return motion_of_sites(driver, groom.root_triangles, groom.root_barycentrics, groom.root_frames)


def apply_rigid(motions: np.ndarray, points: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """Move particles x -> R x + t.

    motions  motion of every strand: columns of R, then t, (strands, 3, 4)
    points   [m], (rows, 3, W)
    strands  strand in every lane of a row, (rows, W)
    returns  [m], (rows, 3, W), in the precision of the points
    """
    turned = np.einsum("rlij,rjl->ril", motions[strands][..., :3], points)
    moved = turned + motions[strands][..., 3].transpose(0, 2, 1)
    return np.ascontiguousarray(moved, points.dtype)


def place(driver: Driver, groom: Groom, rest: np.ndarray, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Move every strand of the groom rigidly with its root.

    driver   the body or the scripted ends that move the roots; None: roots are at rest
    rest     particles of the groom [m], (rows, 3, W) float64
    returns  positions [m], float64, and velocities [m/s], (rows, 3, W)
    """
    strands = np.repeat(layout.strands, np.diff(layout.first), axis=0)
    places, rates = motion_of_roots(driver, groom)
    return apply_rigid(places, rest, strands), apply_rigid(rates, rest, strands).astype(layout.dtype, copy=False)


def follow(driver: Driver, groom: Groom, x: np.ndarray, layout: Layout) -> np.ndarray:
    """Find the velocities [m/s] of particles at x [m], float64, both (rows, 3, W), that go rigidly with their roots."""
    strands = np.repeat(layout.strands, np.diff(layout.first), axis=0)
    return apply_rigid(velocities_around_roots(driver, groom), x, strands).astype(layout.dtype, copy=False)


def velocities_around_roots(driver: Driver, groom: Groom) -> np.ndarray:
    """Return the maps x -> W x + u of what goes rigidly with each root, from places [m] to [m/s], (strands, 3, 4)."""
    places, rates = motion_of_roots(driver, groom)
    spin = rates[:, :, :3] @ places[:, :, :3].transpose(0, 2, 1)
    drift = rates[:, :, 3] - np.einsum("sij,sj->si", spin, places[:, :, 3])
    return np.concatenate([spin, drift[:, :, None]], axis=2)


def clamp_at(driver: Driver, groom: Groom, rest: np.ndarray, layout: Layout, origin: np.ndarray = WORLD) -> Clamp:
    """Find the held particles at a frame, about an origin [m], (3,); other arguments as for `place`.

    Raises BadInput if both ends are in one segment.
    """
    clamped = layout.shape.clamped
    shape = (layout.blocks, clamped, 3, layout.width)
    strands = np.repeat(layout.strands, clamped, axis=0)
    ends = []
    for at, motions in (
        (layout.first[:-1], motion_of_roots(driver, groom)),
        (layout.first[1:] - clamped, _tips(driver, groom)),
    ):
        points = rest[(at[:, None] + np.arange(clamped)).reshape(-1)]
        ends.append(
            [
                apply_rigid(m, points, strands).reshape(shape) if m is not None else np.zeros(shape, rest.dtype)
                for m in motions
            ]
        )
    positions, velocities = (np.concatenate(both, axis=1) for both in zip(*ends, strict=True))
    positions = about(origin, positions, layout)
    velocities = velocities.astype(layout.dtype, copy=False)
    tips = held_tips(driver, groom, layout)
    if len(tips):
        short = layout.strands[(tips > 0.0) & (np.diff(layout.first) < 2 * clamped)[:, None]]
        if len(short):
            strands = name_strands(groom.ids[np.unique(short)])
            raise BadInput(f"strands of one segment are held at both ends: {strands}", right="two segments or more")
    return Clamp(positions, velocities, tips)


def _tips(driver: Driver, groom: Groom) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Rigid motions of the tips and their rates, anything where they are free; None where all are."""
    if isinstance(driver, Ends):
        return np.nan_to_num(driver.tips), np.nan_to_num(driver.tips_rate)
    if groom.tip_triangles is None or groom.tip_barycentrics is None or groom.tip_frames is None:
        return None, None
    return motion_of_sites(driver, np.maximum(groom.tip_triangles, 0), groom.tip_barycentrics, groom.tip_frames)


def held_tips(driver: Driver, groom: Groom, layout: Layout) -> np.ndarray:
    """Return 1 for strands whose tip is held, (blocks, W); no rows where all are free."""
    if isinstance(driver, Ends):
        held = ~np.isnan(driver.tips).any((1, 2))
    else:
        held = np.zeros(0, bool) if groom.tip_triangles is None else groom.tip_triangles != FREE
    return held.astype(layout.dtype)[layout.strands] if held.any() else np.zeros((0, layout.width), layout.dtype)
