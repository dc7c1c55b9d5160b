"""Energy of moving strands."""

import numpy as np
from numba import njit

from hairpipe.geometry.frames import BENDING, GHOST, TWIST, TWISTING, frame_at
from hairpipe.geometry.simd import load, store
from hairpipe.laws.bend_twist import bend
from hairpipe.solve.stage import State
from hairpipe.solve.stretch import set_tensions
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.lattice import altitude_vectors, area_vectors, tetrahedra
from hairpipe.strands.layout import Layout
from hairpipe.strands.network import Network
from hairpipe.strands.rod import Rod


def energies(hair: HairModel, state: State, gravity: float) -> np.ndarray:
    """Energy of every strand [J], (blocks, W): kinetic, of weight above y = 0, of springs between two particles.

    A spring holds T (l - l0) / 2 with T = k (l / l0 - 1). What rods hold in bending and twist is added; left out is
    what the bending of a chain holds, and altitude springs do: those are `altitude_energies`.
    """
    model, layout = hair.model, hair.layout
    found = layout.empty_blocks()
    for block in range(layout.blocks):
        rows = slice(model.first[block], model.first[block + 1])
        x = state.x[rows]
        v = state.v[rows]
        mass = model.mass[rows].copy()
        inverse = model.inverse_lengths[rows]
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


def altitude_energies(model: Network, layout: Layout, x: np.ndarray) -> np.ndarray:
    """Energy of the altitude springs of every strand [J], (blocks, W): k (h / h0 - 1)^2 |h0| / 2 of those that act.

    x  positions [m], (rows, 3, W)

    Where the choice of the spring that acts changes hands, this jumps, as in `laws/altitude.py`.
    """
    found = layout.empty_blocks()
    for block in range(layout.blocks):
        rows = slice(model.first[block], model.first[block + 1])
        areas, volumes = area_vectors(tetrahedra(np.moveaxis(x[rows], 2, 0)))
        sizes = np.linalg.norm(altitude_vectors(areas), axis=3)
        acts = sizes.argmax(axis=2)[:, :, None]
        rest = np.moveaxis(model.inverse_heights[rows], 2, 0)[:, : sizes.shape[1]]
        size, rest = (np.take_along_axis(values, acts, axis=2)[:, :, 0] for values in (sizes, rest))
        heights = np.divide(volumes, size, out=np.zeros_like(size), where=size > 0.0)
        strain = np.where(rest != 0.0, heights * rest - 1.0, 0.0)
        constants = model.constants[rows, 3].T[:, : size.shape[1]]
        held = np.divide(constants * strain**2, np.abs(rest), out=np.zeros_like(size), where=rest != 0.0)
        found[block] = 0.5 * held.sum(axis=1)
    return found


@njit(cache=True, error_model="numpy")
def _add_vertices(model: Rod, block: int, x: np.ndarray, T: np.ndarray, found: np.ndarray) -> None:
    """Add the energy of bending and twist of a block of rods to that found, in place; T is used up."""
    total = load(found, (block,))
    for p in range(GHOST, x.shape[0] - 3):
        row = model.first[block] + p + 1
        (te, tf), (ie, jf), (m1e, m1f) = frame_at(x, T, p)
        vertex = bend(te, tf, ie, jf, m1e, m1f)
        k1, k2 = vertex.k1 - load(model.inverse_lengths, (row, 1)), vertex.k2 - load(model.inverse_lengths, (row, 2))
        psi = load(T, (p + 1, TWIST)) - load(model.inverse_lengths, (row, 3))
        bent, twisted = load(model.inverse_lengths, (row, BENDING)), load(model.inverse_lengths, (row, TWISTING))
        total = total + 0.5 * (bent * (k1 * k1 + k2 * k2) + twisted * psi * psi)
    store(found, (block,), total)
