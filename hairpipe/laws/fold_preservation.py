"""Curls that a body presses keep their shape: fold preservation, after Bridson, Marino and Fedkiw 2003 for cloth.

A body is in contact with the tube around a curl. Let c be the centre line, a mean over one turn, o = x - c, and R the
mean |o| of the groom. With the normal n of the body, point x lies h = o.n + R above the side of the tube that is
nearest to the body, and has the contact distance

    thickness + share min(max(h, 0), 2 R)

All points of a turn are held together, each at its own height, instead of the lowest first and the others on top of
it. With share 0, or on hair without turns, nothing changes.

It serves comparison: curls whose springs hold their shape do not need it, and the target of a contact moves with them,
`graphs/experiments/curls.toml`.

We differ from the paper, Selle et al. 2008, which does not implement this and states that bodies flatten its curls;
and from Bridson et al., whose heights are those of the folds in the animation, not those of the groom.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

_STRAIGHT = 0.02  # a mean turn from segment to segment below this [rad] is not a curl
_LONGEST = 0.5  # of a strand, that a turn may take


class Turns(NamedTuple):
    """The curls of a groom.

    points  number of points per turn, 1 for straight hair, (S,) int32
    radii   mean distance from the centre line [m], (S,)
    """

    points: np.ndarray
    radii: np.ndarray


def turns_of(points: np.ndarray, offsets: np.ndarray) -> Turns:
    """Find the number of points per turn of every strand, and its radius; pure.

    The change of direction from a segment to the next is normal to the axis of a helix and turns about it by the same
    angle every time: 2 pi over that angle is the number of points.

    points  points of the groom [m], (P, 3); offsets  (S+1,) int32
    """
    found = np.ones(len(offsets) - 1, np.int32)
    radii = np.zeros(len(offsets) - 1)
    _find_turns(points, offsets, found)
    centres = np.empty_like(points)
    set_centres(points, offsets, found, centres)
    away = np.linalg.norm(points - centres, axis=1)
    radii[:] = np.add.reduceat(away, offsets[:-1]) / np.diff(offsets)
    return Turns(found, np.where(found > 1, radii, 0.0))


@njit(cache=True)
def _find_turns(points, offsets, found):
    for strand in range(len(found)):
        begin = offsets[strand]
        end = offsets[strand + 1]
        sines, cosines, bend, count = 0.0, 0.0, 0.0, 0
        before, last = np.zeros(3), np.zeros(3)
        for k in range(begin, end - 1):
            tangent = points[k + 1] - points[k]
            tangent /= np.sqrt(np.sum(tangent * tangent))
            change = tangent - last
            if k > begin:
                bend += np.sqrt(np.sum(change * change))
                count += 1
            if k > begin + 1:
                cosines += np.sum(change * before)
                sines += np.sqrt(np.sum(np.cross(before, change) ** 2))
            before, last = change, tangent
        angle = np.arctan2(sines, cosines)
        if count > 0 and bend > _STRAIGHT * count and angle > 0.0:
            turn = round(2.0 * np.pi / angle)
            if 2 < turn <= _LONGEST * (end - begin):
                found[strand] = turn


@njit(cache=True, parallel=True)
def set_centres(points: np.ndarray, offsets: np.ndarray, turns: np.ndarray, centres: np.ndarray) -> None:
    """Set centres, (P, 3), to the mean of points over one turn about each; near an end, over the turn there."""
    for strand in prange(len(turns)):
        begin = offsets[strand]
        end = offsets[strand + 1]
        turn = turns[strand]
        for k in range(begin, end):
            # A whole turn everywhere: near an end a part of one would not have its mean on the axis.
            first = min(max(k - turn // 2, begin), end - turn)
            for c in range(3):
                total = 0.0
                for j in range(first, first + turn):
                    total += points[j, c]
                centres[k, c] = total / turn


@njit(cache=True, parallel=True)
def add_heights(
    points: np.ndarray, offsets: np.ndarray, turns: Turns, normals: np.ndarray, share: float, thickness: np.ndarray
) -> None:
    """Add the heights of points to the thickness, (P,) [m], in place.

    points  [m], (P, 3); normals  normals of the body, zero far from it, (P, 3)
    """
    centres = np.empty_like(points)
    set_centres(points, offsets, turns.points, centres)
    for strand in prange(len(turns.points)):
        radius = turns.radii[strand]
        if radius > 0.0:
            for k in range(offsets[strand] + 1, offsets[strand + 1]):  # Without the root, which is held.
                n = normals[k]
                if n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0:
                    height = radius
                    for c in range(3):
                        height += (points[k, c] - centres[k, c]) * n[c]
                    thickness[k] += share * min(max(height, 0.0), 2.0 * radius)
