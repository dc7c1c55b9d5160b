"""Torsion of a straight strand: the torque compared with GJ, and the shift of a free tip."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_rows
from hairpipe.studies.accuracy.sample import Sample
from hairpipe.studies.accuracy.specimen import Specimen, forces, straight_specimen
from hairpipe.studies.accuracy.statics import balance, motions, stiffness

COLUMNS = ("segments", "twist [rad]", "torque error [%]", "tip shift [% of length per rad]", "no equilibrium")


class Twisted(NamedTuple):
    """A strand between a clamp and a turned, sliding one: twist [rad], particles [m], torque [N m], whether at rest."""

    twist: float
    positions: np.ndarray
    torque: float
    found: bool


def torsion_table(sample: Sample, segments: Sequence[int], twists: Sequence[float]) -> Table:
    """Tabulate the torque for twists of both senses [rad], ascending in size, and the shift of a free tip."""
    rows = []
    for count in segments:
        specimen = straight_specimen(sample, count)
        shift = 100 * tip_shift(specimen)
        back, forth = (list(twist(specimen, [sense * size for size in twists])) for sense in (-1, 1))
        for state in [*reversed(back), *forth]:
            error = 100 * (state.torque / (sample.material.torsion * state.twist / held_length(specimen)) - 1)
            rows.append((count, state.twist, error, shift, int(not state.found)))
    return table_of_rows(COLUMNS, rows)


def held_length(specimen: Specimen) -> float:
    """Length of the rod between the clamps [m]: at the far one half a joint of the network is held, too."""
    return specimen.segment * (specimen.segments - 0.5)


def twist(specimen: Specimen, twists: Sequence[float]) -> Iterator[Twisted]:
    """Turn the far end step by step [rad]; it may slide along the axis, so that no tension arises."""
    x, now, free = specimen.rest, 0.0, motions(specimen, slides=True)
    for turn in twists:
        x, now = twisted_on(specimen, x, turn, turn - now), turn
        at = balance(specimen, x, np.zeros_like(x), free)
        x = at.positions
        held = forces(specimen, x[None])[0, -3:]
        yield Twisted(turn, x, -float(np.cross(x[-3:], held).sum(axis=0)[2]), at.found)


def twisted_on(specimen: Specimen, x: np.ndarray, turn: float, more: float) -> np.ndarray:
    """Twist a strand evenly by more [rad], and put its held ends where a twist of turn [rad] has them."""
    height = np.clip(specimen.rest[:, 2] / specimen.rest[-1, 2], 0, 1)
    guess = turned(x, more * height)
    guess[:3] = specimen.rest[:3]
    guess[-3:] = turned(specimen.rest[-3:], np.full(3, turn))
    guess[-3:, 2] += x[-1, 2] - specimen.rest[-1, 2]
    return guess


def turned(points: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Turn points, (n, 3), about +Z by angles [rad], (n,)."""
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1], points[:, 2]])


def tip_shift(specimen: Specimen) -> float:
    """Shift of a free tip over the length per radian that a small couple about the axis turns it by."""
    arms = specimen.rest[-3:] - specimen.rest[-3:].mean(axis=0)
    inertia = np.eye(3) * np.sum(arms**2) - arms.T @ arms
    load = np.zeros_like(specimen.rest)
    load[-3:] = np.cross(np.linalg.solve(inertia, [0.0, 0.0, 1.0]), arms)
    free = motions(specimen)
    way = free @ np.linalg.solve(free.T @ stiffness(specimen, specimen.rest) @ free, free.T @ load.reshape(-1))
    way = way.reshape(-1, 3)
    angle = np.linalg.solve(inertia, np.cross(arms, way[-3:]).sum(axis=0))[2]
    return float(np.linalg.norm(way[-1, :2]) / abs(angle) / (specimen.segment * specimen.segments))
