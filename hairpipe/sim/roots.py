"""How the body carries the hair: the clamped particles of every strand, between two frames.

The clamp is rigid in the frame of the root's triangle. Between frames it moves on the cubic through both positions and
velocities, so that its speed does not jump at a frame.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Groom, Mesh
from hairpipe.groom.binding import root_frames
from hairpipe.sim.lanes import WIDTH
from hairpipe.sim.lattice import CLAMPED
from hairpipe.sim.layout import Layout

_INSTANT = 1e-5  # [s]; velocities of root frames are differences over this time, the body moving in a straight line


class Clamps(NamedTuple):
    """Clamped particles at one frame: positions [m] and velocities [m/s], (blocks, CLAMPED, 3, WIDTH)."""

    positions: np.ndarray
    velocities: np.ndarray


def _frames(mesh: Mesh, groom: Groom, ahead: float) -> np.ndarray:
    """Root frames on the moving body, (strands, 3, 4), a little ahead in time [s] along its present velocity."""
    points = mesh.points if mesh.velocities is None else mesh.points + ahead * mesh.velocities
    return root_frames(points, mesh.triangles, groom.root_triangles, groom.root_barycentrics)


def carry(frames: np.ndarray, groom: Groom, rest: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """Move particles rigidly from the rest frames of their roots to the given frames.

    frames   of every strand, (strands, 3, 4)
    rest     particles at rest [m], (rows, 3, WIDTH)
    strands  strand in every lane of a row, (rows, WIDTH)
    returns  [m], (rows, 3, WIDTH)
    """
    turn = np.einsum("sij,skj->sik", frames[:, :, :3], groom.root_frames[:, :, :3])
    shift = frames[:, :, 3] - np.einsum("sij,sj->si", turn, groom.root_frames[:, :, 3])
    return np.ascontiguousarray(np.einsum("rlij,rjl->ril", turn[strands], rest) + shift[strands].transpose(0, 2, 1))


def clamps(mesh: Mesh, groom: Groom, rest: np.ndarray, layout: Layout) -> Clamps:
    """Find the clamped particles on the moving body.

    rest  particles of all strands at rest [m], (rows, 3, WIDTH)
    """
    rows = (layout.first[:-1, None] + np.arange(CLAMPED)).reshape(-1)
    positions, velocities = place(mesh, groom, rest[rows], np.repeat(layout.strands, CLAMPED, axis=0))
    shape = (layout.blocks, CLAMPED, 3, WIDTH)
    return Clamps(positions.reshape(shape), velocities.reshape(shape))


def place(mesh: Mesh, groom: Groom, rest: np.ndarray, strands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Put particles on the body as it stands and moves, every strand rigidly with its root.

    rest, strands  as for `carry`
    returns        positions [m] and velocities [m/s], (rows, 3, WIDTH)
    """
    before, now, after = (carry(_frames(mesh, groom, t), groom, rest, strands) for t in (-_INSTANT, 0.0, _INSTANT))
    return now, (after - before) / (2 * _INSTANT)


def between(start: Clamps, end: Clamps, frame: float, time: float) -> np.ndarray:
    """Clamped positions at a time since the start [s], on the cubic Hermite curve over one frame [s].

    returns  [m], (blocks, CLAMPED, 3, WIDTH)
    """
    s = time / frame
    return (
        (1 + 2 * s) * (1 - s) ** 2 * start.positions
        + s * (1 - s) ** 2 * frame * start.velocities
        + s**2 * (3 - 2 * s) * end.positions
        + s**2 * (s - 1) * frame * end.velocities
    )
