"""A cut in a shot: hair is carried over to where the body is after it, every strand rigidly with its root."""

from dataclasses import replace

import numpy as np

from hairpipe.data import Ends, Groom, Mesh
from hairpipe.data.hair import HairState
from hairpipe.sim.layout import Layout
from hairpipe.sim.roots import carry, motion_of_roots


def carry_state(
    state: HairState, groom: Groom, layout: Layout, before: Mesh | Ends | None, after: Mesh | Ends | None
) -> HairState:
    """Move the hair of a body that is somewhere else, and moves otherwise, from one frame to the next; pure.

    before, after  what leads the roots on both sides of the cut

    With the motion x = R X + t of a root before the cut and R_, t_ after it, and Q = R_ R^T,

        x_ = Q (x - t) + t_,   v_ = Q (v - R' X - t') + R_' X + t_',   a_ = Q a

    so that the shape of a strand and its motion against the root are what they were. Tensions, and all else that does
    not point anywhere, stay. No time passes. Gravity does not turn along: hair that hung falls from where it is.
    """
    here, here_rate = motion_of_roots(before, groom)
    there, there_rate = motion_of_roots(after, groom)
    back = here[:, :, :3].transpose(0, 2, 1)
    turn = there[:, :, :3] @ back
    gain = (there_rate[:, :, :3] - turn @ here_rate[:, :, :3]) @ back
    still = np.zeros((len(turn), 3))
    moved = _with(turn, there[:, :, 3] - _apply(turn, here[:, :, 3]))
    gained = _with(gain, there_rate[:, :, 3] - _apply(turn, here_rate[:, :, 3]) - _apply(gain, here[:, :, 3]))
    strands = np.repeat(layout.strands, np.diff(layout.first), axis=0)
    return replace(
        state,
        positions=carry(moved, state.positions, strands),
        velocities=carry(_with(turn, still), state.velocities, strands) + carry(gained, state.positions, strands),
        accelerations=carry(_with(turn, still), state.accelerations, strands),
    )


def _apply(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Multiply a matrix with a vector for every strand, (S, 3, 3) and (S, 3)."""
    return np.einsum("sij,sj->si", matrices, vectors)


def _with(turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Put matrices (S, 3, 3) and vectors (S, 3) side by side, (S, 3, 4)."""
    return np.concatenate([turn, shift[:, :, None]], axis=2)
