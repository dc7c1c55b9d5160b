"""Projection of interpolated hair out of bodies.

A point nearer than its contact distance is moved to the nearest position at its distance from the previous point that
is outside of the tangent plane of the body,

    n.(x_k+1 - x_k) >= h,   h = kept - phi(y) - n.(x_k - y)

and the rest of the strand moves with it. Since the body is not a plane, the test is repeated a few times. Lengths are
unchanged.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, dot, flattened, length, minus, plus, row, scaled, unit
from hairpipe.groom.interpolating import go_on
from hairpipe.groom.resampling import put
from hairpipe.groom.strand_arrays import points_of_strands, thicknesses
from hairpipe.levelset.collider import Collider, SdfSample, probe_union
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.interpolation import Interpolation
from hairpipe.values import BodyParts, LevelSet, Strands

LOOKS = 4
"""Times that bodies are looked at."""


def pushed_out(
    hair: Strands,
    among: np.ndarray,
    surfaces: Sequence[LevelSet],
    parts: Sequence[BodyParts],
    thickness: float,
    frame_dt: float,
) -> Strands:
    """Return hair that is outside of bodies at their frame; pure.

    among      strands to push, (S,) bool
    thickness  contact distance of points, less at the root [m]
    frame_dt   time between frames [s]
    """
    if not (surfaces or parts):
        return hair
    bodies: list[Collider] = [build_collider_field(body, body, frame_dt, Interpolation.linear) for body in surfaces]
    bodies += [build_collider_parts(body, body, frame_dt) for body in parts]
    points = hair.points.copy()
    velocities = hair.velocities.copy()
    kept = thicknesses(hair.offsets, thickness)
    kept[hair.offsets[:-1]] = -np.inf  # roots stay, wherever they are
    looked = np.flatnonzero(np.repeat(among, np.diff(hair.offsets)))
    for _ in range(LOOKS):
        found = probe_union(bodies, points[looked], kept[looked])
        deep = found.distance < kept[looked]
        strands = np.unique(np.searchsorted(hair.offsets, looked[deep], side="right") - 1)
        if not len(strands):
            break
        _push(strands, hair.offsets, looked, found, kept, points, velocities)
        looked = points_of_strands(strands, hair.offsets)
    return replace(hair, points=points, velocities=velocities)


@njit(cache=True, parallel=True, error_model="numpy")
def _push(
    strands: np.ndarray,
    offsets: np.ndarray,
    looked: np.ndarray,
    found: SdfSample,
    kept: np.ndarray,
    points: np.ndarray,
    velocities: np.ndarray,
) -> None:
    """Draw strands, (n,), out of what was found of bodies at some points, (m,) ascending, in place."""
    for n in prange(len(strands)):
        s = strands[n]
        at = np.searchsorted(looked, offsets[s] + 1)
        before = row(points, offsets[s])
        moved = False
        for i in range(offsets[s] + 1, offsets[s + 1]):
            y = row(points, i)
            l = length(minus(row(points, i), before))
            before = y
            known = at < len(looked) and looked[at] == i
            deep = known and found.distance[at] < kept[i]
            if moved or deep:  # What hangs on a moved point follows; before it nothing changes, to the bit.
                root = row(points, i - 1)
                rate = row(velocities, i - 1)
                moved = True
                x, v = go_on(root, rate, l, minus(y, root), minus(row(velocities, i), rate))
                if deep:
                    normal = row(found.normal, at)
                    x = _outside(root, x, l, normal, kept[i] - found.distance[at] + dot(normal, y))
                    v = plus(v, scaled(max(dot(normal, minus(row(found.velocity, at), v)), 0.0), normal))
                put(velocities, i, v)
                put(points, i, x)
            at += known  # Both ascend: one walk finds what was looked at of this strand.


@inlined
def _outside(before: Vector, x: Vector, l: float, normal: Vector, level: float) -> Vector:
    # The place at a distance l from the point before that is nearest to x of those above a plane n.x = level.
    h = level - dot(normal, before)
    if dot(normal, minus(x, before)) >= h:
        return x
    h = min(h, l)  # No higher than straight up along the normal: the length stays.
    aside = unit(flattened(minus(x, before), normal), (0.0, 0.0, 0.0))
    return plus(before, plus(scaled(h, normal), scaled(np.sqrt(l * l - h * h), aside)))
