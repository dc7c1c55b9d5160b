"""Links that support the hair as groomed: one linear solve, after which hair neither sinks nor creeps.

With K at rest, and roots held, (sum K d d^T + eps) u = m g gives the sag of particles, and T = K d . u' the tension of
every link; its rest length becomes l - T / K. The diagonal eps, 1e-4 of the mean one, bounds the sag on links that
cannot support it. Hair on a body still sinks: its support is unknown here.
"""

import numpy as np

from hairpipe.particles.model import Model
from hairpipe.particles.solve import build_system, set_blocks, solve
from hairpipe.particles.stiffness import measure_links, stiffen

SOFT = 1e-4
"""Regularisation of the diagonal, over its mean."""
EXACT = 1e-4
"""Error of the solve, as `TOLERANCE` of a step."""


def rest_lengths(model: Model, points: np.ndarray, axial: np.ndarray, gravity: float, strain: float) -> np.ndarray:
    """Return the rest lengths of links [m], (E,), for equilibrium of particles at points [m], (N, 3); pure.

    axial    E A of every particle [N], (N,)
    gravity  [m/s^2]
    strain   maximum relative change of a length
    """
    links = model.links
    count = len(points)
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    measure_links(links, points, ways)
    stiffen(links, model.reach, axial, ways, stiffness)
    d = ways[:, :3]
    blocks = np.zeros((count, 6))
    outer = stiffness[:, None] * d[:, [0, 0, 0, 1, 1, 2]] * d[:, [0, 1, 2, 1, 2, 2]]
    for end in range(2):
        np.add.at(blocks, links.ends[:, end], outer)
    blocks[:, [0, 3, 5]] += SOFT * blocks[model.deep :, [0, 3, 5]].mean()
    joins = np.sqrt(stiffness)[:, None] * d
    system = build_system(links, model.deep)
    system.joins[:] = np.pad(joins[links.by], ((0, 0), (0, 1))).ravel()
    set_blocks(system, blocks)
    sunk = np.zeros(4 * count, np.float32)
    residual = np.zeros((count, 4), np.float32)
    residual[model.deep :, 1] = -gravity * model.masses[model.deep :]
    residual = residual.ravel()
    solve(system, residual, sunk, EXACT, 0.0)
    u = sunk.reshape(-1, 4)[:, :3].astype(float)
    stretch = np.sum(d * (u[links.ends[:, 1]] - u[links.ends[:, 0]]), axis=1) / links.lengths
    return links.lengths * (1.0 - np.clip(stretch, -strain, strain))
