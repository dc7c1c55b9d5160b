"""The spring network of a whole head, laid out eight strands to a block."""

from typing import NamedTuple

import numpy as np

from hairpipe.sim import lattice
from hairpipe.sim.calibration import spring_constants
from hairpipe.sim.lanes import WIDTH
from hairpipe.sim.layout import Layout
from hairpipe.sim.material import Material


class Network(NamedTuple):
    """Constants of every strand's springs; rows are particles in the order of the lattice, block after block.

    first            rows of block b are first[b]:first[b+1], (blocks+1,) int64
    mass             [kg], (rows, WIDTH)
    inverse_lengths  1 / l0 of the springs to the next three particles [1/m], 0 past the end, (rows, 3, WIDTH)
    inverse_heights  signed 1 / h0 of the seven altitude springs [1/m], (rows, 7, WIDTH)
    constants        edge, bending, torsion and altitude constant [N], (blocks, 4, WIDTH)
    """

    first: np.ndarray
    mass: np.ndarray
    inverse_lengths: np.ndarray
    inverse_heights: np.ndarray
    constants: np.ndarray


def build_network(layout: Layout, points: np.ndarray, material: Material) -> tuple[Network, np.ndarray]:
    """Make the network whose rest shape is the groom.

    points   of the groom [m], (p, 3)
    returns  the network, and its particles at rest [m], (rows, 3, WIDTH)
    """
    rows = layout.first[-1]
    network = Network(
        layout.first,
        np.empty((rows, WIDTH)),
        np.empty((rows, 3, WIDTH)),
        np.empty((rows, 7, WIDTH)),
        np.empty((layout.blocks, 4, WIDTH)),
    )
    rest = np.empty((rows, 3, WIDTH))
    for blocks, axis in layout.classes(points):
        particles = lattice.perturb(axis)
        length = np.linalg.norm(np.diff(axis, axis=1), axis=2).mean(1)
        fill = _Filler(layout, blocks)
        fill(rest, particles)
        fill(network.mass, lattice.masses(length, axis.shape[1] - 1, material.line_density))
        fill(network.inverse_lengths, _inverse(lattice.rest_lengths(particles)))
        fill(network.inverse_heights, _inverse(lattice.rest_heights(particles)))
        constants = spring_constants(material, length)
        network.constants[blocks] = constants.reshape(4, len(blocks), WIDTH).transpose(1, 0, 2)
    return network, rest


class _Filler:
    """Writes values of strands, (strands, particles, ...), into the rows of consecutive blocks, in place."""

    def __init__(self, layout: Layout, blocks: np.ndarray) -> None:
        self.rows = slice(layout.first[blocks[0]], layout.first[blocks[-1] + 1])

    def __call__(self, target: np.ndarray, values: np.ndarray) -> None:
        lanes = values.reshape(-1, WIDTH, *values.shape[1:])
        target[self.rows] = np.moveaxis(lanes, 1, -1).reshape(-1, *values.shape[2:], WIDTH)


def _inverse(values: np.ndarray) -> np.ndarray:
    return np.divide(1.0, values, out=np.zeros_like(values), where=values != 0)
