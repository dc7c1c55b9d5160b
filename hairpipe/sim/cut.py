"""A cut in a shot: hair is carried over to where the body is after it, every strand rigidly with its root."""

from dataclasses import replace

import numpy as np

from hairpipe.data import Ends, Groom, Mesh
from hairpipe.data.hair import HairState
from hairpipe.sim.boundary import apply_rigid, follow, motion_of_roots
from hairpipe.sim.layout import Layout


def carry_state(
    state: HairState, groom: Groom, layout: Layout, before: Mesh | Ends | None, after: Mesh | Ends | None
) -> HairState:
    """Move the hair of a body that is somewhere else, and moves otherwise, from one frame to the next; pure.

    before, after  what leads the roots on both sides of the cut

    With the motion x = R X + t of a root before the cut and R_, t_ after it, Q = R_ R^T, and the velocities u and u_
    of what goes rigidly with the root at x before it and at x_ after it,

        x_ = Q (x - t) + t_,   v_ = Q (v - u) + u_,   a_ = Q a

    so that the shape of a strand and its motion against the root are what they were. Tensions, and all else that does
    not point anywhere, stay. No time passes. Gravity does not turn along: hair that hung falls from where it is.
    """
    here, _ = motion_of_roots(before, groom)
    there, _ = motion_of_roots(after, groom)
    turn = there[:, :, :3] @ here[:, :, :3].transpose(0, 2, 1)
    shift = there[:, :, 3] - np.einsum("sij,sj->si", turn, here[:, :, 3])
    turned, moved = _with(turn, np.zeros_like(shift)), _with(turn, shift)
    strands = np.repeat(layout.strands, np.diff(layout.first), axis=0)
    against = state.velocities - follow(before, groom, state.positions, layout)
    positions = apply_rigid(moved, state.positions, strands)
    return replace(
        state,
        positions=positions,
        velocities=apply_rigid(turned, against, strands) + follow(after, groom, positions, layout),
        accelerations=apply_rigid(turned, state.accelerations, strands),
    )


def _with(turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Put matrices (S, 3, 3) and vectors (S, 3) side by side, (S, 3, 4)."""
    return np.concatenate([turn, shift[:, :, None]], axis=2)
