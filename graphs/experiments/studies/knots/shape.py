"""The shape of a loose knot: a circle, whose two ends go around each other where they meet, and straight tails."""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.groom.resampling import divide
from hairpipe.groom.strands import unbound
from hairpipe.values import Groom

_FINE = 2000  # points on each part of the curve
_SLOPE = 0.3
"""Slope of the strands in the braid against its axis."""


def tied_strand(length: float, segments: int, radius: float, gap: float, crossings: int) -> Groom:
    """Return a strand along +X with a knot in its middle, of equal segments; its root is at the origin.

    length     of the strand [m]
    radius     of the circle, which is in the plane of X and Y [m]
    gap        distance between the strands of the braid [m]
    crossings  of these strands: odd; 1 is a loop without a knot, 3 an overhand knot

    BadInput where crossings are even, or the strand is too short for the knot.
    """
    if crossings % 2 == 0:
        raise BadInput(f"crossings = {crossings}", right="an odd number: the strand goes on where it came from")
    knot = knotted_curve(radius, gap, crossings)
    tail = 0.5 * (length - float(np.linalg.norm(np.diff(knot, axis=0), axis=1).sum()))
    if tail < length / segments:
        raise BadInput(f"a knot of radius {radius:g} m in a strand of {length:g} m", right="a longer strand")
    along = np.array([tail, 0.0, 0.0])
    points = np.zeros((segments + 1, 3))
    divide(np.concatenate([[knot[0] - along], knot, [knot[-1] + along]]), points)
    points = (points - points[0]) * (length / segments / np.linalg.norm(points[1] - points[0]))
    frame = np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])
    return unbound(points[None], frame[None])


def knotted_curve(radius: float, gap: float, crossings: int) -> np.ndarray:
    """Return the curve between the straight tails [m], (n, 3): a braid, the circle, and the braid again.

    On the way through the braid each strand makes half as many turns as there are crossings, from below to above.

    BadInput where the braid is longer than the circle is wide.
    """
    turned = np.pi * crossings * np.linspace(0.0, 1.0, _FINE)
    half = 0.25 * gap * turned[-1] / _SLOPE
    if half >= radius:
        raise BadInput(f"a braid of {2 * half:.3g} m in a circle of radius {radius:g} m", right="a larger radius")
    braid = np.column_stack([np.linspace(-half, half, _FINE), -0.5 * gap * np.cos(turned), -0.5 * gap * np.sin(turned)])
    opposite = braid * [1.0, -1.0, -1.0]
    left_out = np.arcsin(half / radius)
    around = np.linspace(left_out, 2.0 * np.pi - left_out, _FINE)[1:-1]
    centre = 0.5 * gap + radius * np.cos(left_out)
    circle = np.column_stack([radius * np.sin(around), centre - radius * np.cos(around), np.zeros(len(around))])
    return np.concatenate([braid, circle, opposite])
