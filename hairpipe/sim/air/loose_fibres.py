"""Wind on particles, each of which represents a number of parallel fibres."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hairpipe.sim.air.breeze import Breeze
from hairpipe.sim.air.wind import Wind
from hairpipe.sim.interactions import Prediction


class LooseFibres(NamedTuple):
    """Segments of fibre at particles.

    points, directions, velocities  [m], unit vectors, [m/s], (N, 3) each
    counts                          number of parallel fibres, (N,)
    segment                         length of each [m]
    diameter                        of a fibre [m]
    """

    points: np.ndarray
    directions: np.ndarray
    velocities: np.ndarray
    counts: np.ndarray
    segment: float
    diameter: float


def add_wind(wind: Wind, hair: LooseFibres, seconds: float, push: np.ndarray, drag: np.ndarray) -> None:
    """Add the force push - drag v of the air at a time of the shot [s], in place.

    push  [N], (N, 3)
    drag  symmetric xx xy xz yy yz zz [kg/s], (N, 6)

    All fibres of a particle shield other hair.
    """
    if wind.shielding is not None:
        hairs = wind.shielding.hairs * float(hair.counts.mean())
        wind = replace(wind, shielding=replace(wind.shielding, hairs=hairs))
    half = 0.5 * hair.segment * hair.directions
    count = len(hair.counts)
    ends = np.stack([hair.points - half, hair.points + half], axis=1).reshape(-1, 3)
    pace = np.repeat(hair.velocities, 2, axis=0)
    still = np.zeros(2 * count)
    at = Prediction(ends, pace, pace, still, still, np.ones(2 * count, bool), 0.0, 0.0, seconds)
    pushes, drags = np.zeros((2 * count, 3)), np.zeros((2 * count, 6))
    offsets = np.arange(0, 2 * count + 1, 2, dtype=np.int32)
    Breeze(wind, hair.diameter, offsets).linearise(at, pushes, drags)
    push += hair.counts[:, None] * pushes.reshape(count, 2, 3).sum(axis=1)
    drag += hair.counts[:, None] * drags.reshape(count, 2, 6).sum(axis=1)
