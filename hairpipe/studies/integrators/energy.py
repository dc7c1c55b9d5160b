"""Energy of moving strands."""

import numpy as np

from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.solve.stretch import set_tensions
from hairpipe.sim.state import State


def energies(hair: HairModel, state: State, gravity: float) -> np.ndarray:
    """Energy of every strand [J], (blocks, W): kinetic, of weight above y = 0, and of springs between two particles.

    A spring holds T (l - l0) / 2 with T = k (l / l0 - 1). What altitude springs hold is left out.
    """
    model, layout = hair.model, hair.layout
    found = layout.empty_blocks()
    for block in range(layout.blocks):
        rows = slice(model.first[block], model.first[block + 1])
        x, v, mass, inverse = state.x[rows], state.v[rows], model.mass[rows].copy(), model.inverse_lengths[rows]
        mass[: model.shape.clamped] = 0.0
        moving = 0.5 * np.einsum("pl,pcl,pcl->l", mass, v, v) + gravity * np.einsum("pl,pl->l", mass, x[:, 1])
        tensions = np.zeros_like(inverse)
        set_tensions(model, block, x, tensions)
        for offset in range(1, inverse.shape[1] + 1):
            rest = np.divide(1.0, inverse[:-offset, offset - 1])
            lengths = np.linalg.norm(x[offset:] - x[:-offset], axis=1)
            moving = moving + 0.5 * np.sum(tensions[:-offset, offset - 1] * (lengths - rest), axis=0)
        found[block] = moving
    return found
