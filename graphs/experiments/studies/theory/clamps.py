"""Rods held at one end or at both: boundary conditions for `balance`, and the way there from the shape at rest."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.studies.theory.kirchhoff import COUPLE, FORCE, POINT, TURN, Rod, Shape, balance
from hairpipe.graphs.experiments.studies.theory.rod_frames import CONJUGATE, left, quaternion_of, tangents

_FURTHEST = 0.3
"""Most that the quaternion of a section may change from one load to the next: further off lie other solutions."""
_SMALLEST = 1e-4
"""Fraction of the load below which the way is taken to have ended."""
_ON_THE_WAY, _AT_ITS_END = 1e-3, 1e-8
"""Tolerances of the equations."""


class Clamp(NamedTuple):
    """Where the end of a rod is held: point [m], (3,), and frame, its columns d1, d2, d3, (3, 3)."""

    point: np.ndarray
    frame: np.ndarray


def rest_shape(rod: Rod, start: Clamp) -> Shape:
    """Draw the rod without any load: a helix, an arc or a line; where `natural` grows, a spiral."""
    spin = float(np.linalg.norm(rod.natural_at(np.array([0.0, rod.length])), axis=0).max())
    arc = np.linspace(0, rod.length, 20 + int(10 * spin * rod.length))
    vectors = (rod.natural_at((arc[1:] + arc[:-1]) / 2) * np.diff(arc)).T
    halves = np.linalg.norm(vectors, axis=1) / 2
    turns = np.column_stack([np.cos(halves), np.sinc(halves / np.pi)[:, None] * vectors / 2])
    quaternions = np.empty((4, len(arc)))
    quaternions[:, 0] = quaternion_of(start.frame)
    for k, turn in enumerate(turns):
        quaternions[:, k + 1] = left(quaternions[:, k]) @ turn
    along = tangents(quaternions)
    steps = (along[:, 1:] + along[:, :-1]) / 2 * np.diff(arc)
    points = start.point + np.concatenate([np.zeros((1, 3)), np.cumsum(steps.T, axis=0)])
    nothing = np.zeros_like(points)
    return Shape(arc, points, quaternions.T, nothing, nothing)


def hang_rod(
    rod: Rod,
    start: Clamp,
    force: np.ndarray | None = None,
    couple: np.ndarray | None = None,
    guess: Shape | None = None,
) -> Shape:
    """Solve a rod that is clamped at its start, for weight and end loads that grow from nothing.

    force   on the free end [N], (3,)
    couple  on the free end [N m], (3,)
    guess   shape of a similar rod near which it is solved at once, in place of a growing load

    ArithmeticError where the way ends before the full load: there the rod buckles.
    """
    force, couple = (np.zeros(3) if load is None else load for load in (force, couple))
    if guess is not None:
        return _hang(rod, start, force, couple, guess, _AT_ITS_END)
    size = np.linalg.norm(rod.weight) * rod.length + np.linalg.norm(force) + np.linalg.norm(couple) / rod.length
    shape = rest_shape(rod, start)
    done = 0.0
    step = rod.bending / rod.length**2 / max(float(size), 1e-300)
    while done < 1:
        part = min(done + step, 1.0)
        try:
            found = _hang(
                replace(rod, weight=part * rod.weight), start, part * force, part * couple, shape, _ON_THE_WAY
            )
        except ArithmeticError:
            found = None
        if found is not None and _distance(shape, found) < _FURTHEST:
            shape = found
            done = part
            step = 2 * step
        elif step > _SMALLEST:
            step /= 4
        else:
            raise ArithmeticError(f"the rod finds no equilibrium near {part:.2%} of its load")
    return _hang(rod, start, force, couple, shape, _AT_ITS_END)


def span_rod(rod: Rod, start: Clamp, end: Clamp, guess: Shape) -> Shape:
    """Solve a rod that is clamped at both ends, near a guess, which says how often it is twisted."""

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.concatenate([_held(rod, start, a), _held(rod, end, b)[:6]])

    return balance(rod, ends, guess, _AT_ITS_END)


def _hang(rod: Rod, start: Clamp, force: np.ndarray, couple: np.ndarray, guess: Shape, tolerance: float) -> Shape:
    pull = force * rod.length**2 / rod.bending
    turn = couple * rod.length / rod.bending

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.concatenate([_held(rod, start, a), b[FORCE] - pull, b[COUPLE] - turn])

    return balance(rod, ends, guess, tolerance)


def _held(rod: Rod, clamp: Clamp, state: np.ndarray) -> np.ndarray:
    """Residuals of a clamp, (7,): point, frame (the quaternion may have either sign), and the quaternion's length."""
    q = state[TURN]
    apart = left(quaternion_of(clamp.frame) * CONJUGATE) @ q
    return np.concatenate([state[POINT] - clamp.point / rod.length, apart[1:], [q @ q - 1]])


def _distance(before: Shape, after: Shape) -> float:
    """Largest difference of the quaternions of a section."""
    old = np.array([np.interp(after.arc, before.arc, part) for part in before.quaternions.T])
    return float(np.linalg.norm(after.quaternions.T - old, axis=0).max())
