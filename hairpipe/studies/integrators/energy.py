"""Energy of moving strands."""

import numpy as np
from numba import njit

from hairpipe.kernels.simd import load, store
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.solve.stretch import set_tensions
from hairpipe.sim.state import State
from hairpipe.sim.strands.rod.frames import BENDING, GHOST, TWIST, TWISTING, carry_frame
from hairpipe.sim.strands.rod.rod import Rod
from hairpipe.sim.strands.rod.vertex import bend


def energies(hair: HairModel, state: State, gravity: float) -> np.ndarray:
    """Energy of every strand [J], (blocks, W): kinetic, of weight above y = 0, of springs between two particles.

    A spring holds T (l - l0) / 2 with T = k (l / l0 - 1). What rods hold in bending and twist is added; what altitude
    springs and the bending of a chain hold is left out.
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
            pull = tensions[:-offset, offset - 1]
            rest = np.divide(1.0, inverse[:-offset, offset - 1], out=np.zeros_like(pull), where=pull != 0.0)
            lengths = np.linalg.norm(x[offset:] - x[:-offset], axis=1)
            moving = moving + 0.5 * np.sum(pull * (lengths - rest), axis=0)
        found[block] = moving
        if isinstance(model, Rod):
            _add_vertices(model, block, x, state.T[rows].copy(), found)
    return found


@njit(cache=True, error_model="numpy")
def _add_vertices(model: Rod, block: int, x: np.ndarray, T: np.ndarray, found: np.ndarray) -> None:
    """Add the energy of bending and twist of a block of rods to that found, in place; T is used up."""
    total = load(found, (block,))
    for p in range(GHOST, x.shape[0] - 3):
        row, vertex = model.first[block] + p + 1, bend(*carry_frame(x, T, p))
        k1, k2 = vertex.k1 - load(model.inverse_lengths, (row, 1)), vertex.k2 - load(model.inverse_lengths, (row, 2))
        psi = load(T, (p + 1, TWIST)) - load(model.inverse_lengths, (row, 3))
        bent, twisted = load(model.inverse_lengths, (row, BENDING)), load(model.inverse_lengths, (row, TWISTING))
        total = total + 0.5 * (bent * (k1 * k1 + k2 * k2) + twisted * psi * psi)
    store(found, (block,), total)
