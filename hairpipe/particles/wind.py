"""Wind on particles, by the drag of the fibres that they stand for (`hairpipe/sim/air`).

A particle of mass m stands for m / lambda of fibre along its direction, lambda being the mass per length: the wind sees
a segment of the length of a link there, as many times over. Two-way air of particles, as in the paper, is not here:
with shielding, hair keeps the wind from the hair behind it.
"""

from dataclasses import replace

import numpy as np

from hairpipe.particles.settings import Fibre
from hairpipe.particles.step import Forces
from hairpipe.sim.air.breeze import Breeze
from hairpipe.sim.air.wind import Wind
from hairpipe.sim.interactions import Prediction


def add_wind(
    wind: Wind, fibre: Fibre, segment: float, masses: np.ndarray, now: tuple, seconds: float, forces: Forces
) -> None:
    """Add the force of the air on particles, in place.

    segment  length of a segment of hair at a particle [m]
    masses   [kg], (N,)
    now      points [m], directions and velocities [m/s], (N, 3) each
    seconds  of the shot, at which the wind is taken [s]
    """
    points, directions, velocities = now
    times = masses / (fibre.line_density * segment)
    if wind.shielding is not None:
        wind = replace(wind, shielding=replace(wind.shielding, hairs=wind.shielding.hairs * float(times.mean())))
    half, count = 0.5 * segment * directions, len(masses)
    ends = np.stack([points - half, points + half], axis=1).reshape(-1, 3)
    pace = np.repeat(velocities, 2, axis=0)
    push, drag = np.zeros((2 * count, 3)), np.zeros((2 * count, 6))
    offsets = np.arange(0, 2 * count + 1, 2, dtype=np.int32)
    still = np.zeros(2 * count)
    at = Prediction(ends, pace, pace, still, still, np.ones(2 * count, bool), 0.0, 0.0, seconds)
    Breeze(wind, fibre.diameter, offsets).linearise(at, push, drag)
    forces.push[:] += times[:, None] * push.reshape(count, 2, 3).sum(axis=1)
    forces.drag[:] += times[:, None] * drag.reshape(count, 2, 6).sum(axis=1)
