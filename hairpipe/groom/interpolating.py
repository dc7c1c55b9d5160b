"""Hair interpolated between key hairs: its own segments at rest, rotated like those of nearby keys.

    t_k = l_k sum_g w_g Q_g,k T_k / |sum_g w_g Q_g,k T_k|,   x_k+1 = x_k + t_k

with T_k a segment of the hair at rest, l_k its length, Q_g,k the rotation since rest of key g at the same position
along it, see `keys`. It is the kinematic limit of Hsu et al. 2024, Real-time Physically Guided Hair Interpolation:
lengths are exact, curls do not flatten, and rigid motions are exact. Velocities are the exact derivative.

Tips taper towards the nearest key in clumps:

    y(a) = x(a) + p s((a - b) / (1 - b)) (x_g(a) - x(a)),   s(t) = t^2 (3 - 2 t)

at a share a of the length, from the share b on, with x_g the nearest of the keys that it follows and p the pull.
Segments have the directions of those between the y, and their original lengths. Velocities are the exact derivative.

The hair transports the normals of its shell, N_k(now) = Q_k grad S(x_k at rest), with Q_k the rotation of the segment
after point k since rest: Petrovic, Henne, Anderson 2005, Sec. 4.1, who use frames of Bishop 1975 that are fixed to the
head at the root.

A point nearer to a body than its contact distance is moved to the nearest position at its distance from the previous
point that is outside of the tangent plane of the body, and the rest of the strand with it,

    n.(x_k+1 - x_k) >= h,   h = kept - phi(y) - n.(x_k - y)

Since the body is not a plane, the test is repeated a few times. Lengths are unchanged.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider, SdfSample, probe_union
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, cross, dot, flattened, length, minus, mix, plus, put, row, scaled, unit
from hairpipe.groom.key_weights import FOLLOWED, KeyWeights
from hairpipe.groom.keys import KeyTurns, turned, turns_since
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import BodyParts, Groom, LevelSet, Normals, Strands
from hairpipe.values.strand_arrays import points_of_strands, thicknesses

_TINY = 1e-12  # of a segment; a way that is shorter has no direction


def interpolated(
    hair: Strands, keys: Groom, groom: Groom, followed: KeyWeights, roots: tuple[np.ndarray, np.ndarray]
) -> Strands:
    """Return all hairs of a groom at a frame, with the keys unchanged, and as wide as these; pure.

    hair   hair of the keys at the frame
    roots  rigid motions of the roots of the groom, x -> R x + t, and their time derivatives, (S, 3, 4) float64
    """
    motions, rates = roots
    turns = turns_since(keys.points, hair, motions[followed.homes], rates[followed.homes])
    points = np.empty_like(groom.points)
    velocities = np.empty((len(groom.points), 3), np.float32)
    widths = None
    if hair.widths is not None:
        widths = np.empty(len(points), np.float32)
        _mix_widths(followed, keys.offsets, hair.widths, groom.offsets, widths)
    now = hair.points, hair.velocities
    _interpolate(followed, turns, now, followed.rest, groom.offsets, roots, points, velocities)
    return Strands(points, velocities, groom.offsets, hair.diameter, widths)


@njit(cache=True, parallel=True, error_model="numpy")
def _interpolate(
    followed: KeyWeights,
    turns: KeyTurns,
    keys: tuple[np.ndarray, np.ndarray],
    rest: np.ndarray,
    offsets: np.ndarray,
    roots: tuple[np.ndarray, np.ndarray],
    points: np.ndarray,
    velocities: np.ndarray,
) -> None:
    motions, rates = roots
    for s in prange(len(offsets) - 1):
        begin = offsets[s]
        end = offsets[s + 1]
        own = followed.own[s]
        if own >= 0:  # Keys as they were simulated, to the bit.
            points[begin:end] = keys[0][turns.offsets[own] : turns.offsets[own + 1]]
            velocities[begin:end] = keys[1][turns.offsets[own] : turns.offsets[own + 1]]
            continue
        x, v = moved(motions, s, row(rest, begin)), moved(rates, s, row(rest, begin))
        put(points, begin, x)
        put(velocities, begin, v)
        for k in range(end - begin - 1):
            T = minus(row(rest, begin + k + 1), row(rest, begin + k))
            way, speed = _turned_by_keys(followed, turns, s, k, end - begin - 1, T)
            x, v = go_on(x, v, length(T), way, speed)
            put(points, begin + k + 1, x)
            put(velocities, begin + k + 1, v)


@njit(cache=True, parallel=True, error_model="numpy")
def _mix_widths(followed, firsts, theirs, offsets, widths) -> None:  # noqa: ANN001
    """Write the mean of the widths of its keys, at equal shares of their points, to every point of all hairs."""
    for s in prange(len(offsets) - 1):
        own = followed.own[s]
        segments = max(offsets[s + 1] - offsets[s] - 1, 1)
        for k in range(offsets[s + 1] - offsets[s]):
            total, whole = 0.0, 0.0
            for j in range(FOLLOWED):
                g = own if own >= 0 else followed.keys[s, j]
                weight = 1.0 if own >= 0 else followed.weights[s, j]
                if weight > 0.0:
                    count = firsts[g + 1] - firsts[g] - 1
                    below = min(k * count // segments, count - 1)  # In whole numbers: equal counts meet point to point.
                    rest = k * count / segments - below
                    a = firsts[g] + below
                    total += weight * (theirs[a] + rest * (theirs[a + 1] - theirs[a]))
                    whole += weight
            widths[offsets[s] + k] = total / whole


@inlined
def _turned_by_keys(
    followed: KeyWeights, turns: KeyTurns, s: int, k: int, segments: int, T: Vector
) -> tuple[Vector, Vector]:
    """Segment k of a hair as its keys turn it, and the derivative of that by time."""
    way = speed = (0.0, 0.0, 0.0)
    for j in range(FOLLOWED):
        weight = followed.weights[s, j]
        if weight > 0.0:
            g = followed.keys[s, j]
            first = turns.offsets[g]
            below, rest = middle_among(k, segments, turns.offsets[g + 1] - first - 1)
            t = turned(turns.turns, first + below, T)
            dt = cross(row(turns.spins, first + below), t)
            if rest > 0.0:  # Exactly on a middle there may be no segment above.
                above = turned(turns.turns, first + below + 1, T)
                t = mix(t, above, rest)
                dt = mix(dt, cross(row(turns.spins, first + below + 1), above), rest)
            way, speed = plus(way, scaled(weight, t)), plus(speed, scaled(weight, dt))
    return way, speed


@inlined
def go_on(x: Vector, v: Vector, l: float, way: Vector, speed: Vector) -> tuple[Vector, Vector]:
    """Return the point at a distance l [m] from x along a vector `way` [m], and its velocity [m/s].

    That is x + l way/|way|, with v the velocity of x and `speed` the rate of change of `way` [m/s]. A zero vector, as
    between opposed keys, is replaced by the downward direction.
    """
    size = length(way)
    if size <= _TINY * l:
        return plus(x, (0.0, -l, 0.0)), v
    t = scaled(1.0 / size, way)
    return plus(x, scaled(l, t)), plus(v, scaled(l / size, flattened(speed, t)))


@inlined
def middle_among(k: int, segments: int, theirs: int) -> tuple[int, float]:
    """Return the middle of a key's segment before that of segment k of a hair, and the fraction towards the next.

    In integer arithmetic, so that coincident middles are exact.
    """
    if theirs == segments:
        return k, 0.0
    place = (2 * k + 1) * theirs - segments
    if place <= 0:
        return 0, 0.0
    below = place // (2 * segments)
    if below >= theirs - 1:
        return theirs - 1, 0.0
    return below, (place - 2 * segments * below) / (2 * segments)


@inlined
def moved(motions: np.ndarray, s: int, x: Vector) -> Vector:
    """Return a place moved by rigid motion s of (S, 3, 4)."""
    return (
        motions[s, 0, 0] * x[0] + motions[s, 0, 1] * x[1] + motions[s, 0, 2] * x[2] + motions[s, 0, 3],
        motions[s, 1, 0] * x[0] + motions[s, 1, 1] * x[1] + motions[s, 1, 2] * x[2] + motions[s, 1, 3],
        motions[s, 2, 0] * x[0] + motions[s, 2, 1] * x[1] + motions[s, 2, 2] * x[2] + motions[s, 2, 3],
    )


def clumped(hair: Strands, keys: Strands, followed: KeyWeights, pull: float, begin: float) -> Strands:
    """Return hair with its tips pulled towards the keys that it follows; pure.

    pull   share of the distance to the key by which the tip moves
    begin  share of the length at which the pull begins, less than 1
    """
    points = hair.points.copy()
    velocities = hair.velocities.copy()
    _clump(followed, (keys.points, keys.velocities, keys.offsets), hair.offsets, (pull, begin), points, velocities)
    return replace(hair, points=points, velocities=velocities)


@njit(cache=True, parallel=True, error_model="numpy")
def _clump(
    followed: KeyWeights,
    keys: tuple[np.ndarray, np.ndarray, np.ndarray],
    offsets: np.ndarray,
    how: tuple[float, float],
    points: np.ndarray,
    velocities: np.ndarray,
) -> None:
    places, speeds, firsts = keys
    pull, begin = how
    for s in prange(len(offsets) - 1):
        if followed.own[s] >= 0:  # A key is not drawn to itself.
            continue
        g = followed.keys[s, 0]
        first = offsets[s]
        segments = offsets[s + 1] - offsets[s] - 1
        theirs = firsts[g + 1] - firsts[g] - 1
        x, v = row(points, first), row(velocities, first)
        before, last, last_speed = x, x, v  # the point before, and where it was drawn to
        for k in range(1, segments + 1):
            i = first + k
            l = length(minus(row(points, i), before))
            before = row(points, i)
            share = min(max((k / segments - begin) / (1.0 - begin), 0.0), 1.0)
            near = pull * share * share * (3.0 - 2.0 * share)
            below = min(k * theirs // segments, theirs - 1)  # In whole numbers: equal counts meet point to point.
            rest = k * theirs / segments - below
            a = firsts[g] + below
            y = mix(before, mix(row(places, a), row(places, a + 1), rest), near)
            speed = mix(row(velocities, i), mix(row(speeds, a), row(speeds, a + 1), rest), near)
            x, v = go_on(x, v, l, minus(y, last), minus(speed, last_speed))
            last, last_speed = y, speed
            put(points, i, x)
            put(velocities, i, v)


def probe_shell(points: np.ndarray, shell: LevelSet) -> SdfSample:
    """Return the signed distance and its unit gradient at points [m], (P, 3); inf and 0 beyond its band."""
    return probe_union([build_collider_field(shell, shell, 1.0, Interpolation.linear)], points)


def rotated_normals(rest: np.ndarray, groom: Groom, hair: Strands, roots: tuple[np.ndarray, np.ndarray]) -> Normals:
    """Return unit normals, `rest` at the points of the groom, (P, 3), rotated with the hair since rest; pure.

    Roots have rigid motions and their time derivatives, (S, 3, 4). BadInput if hair and groom are not the same strands.
    """
    if not np.array_equal(hair.offsets, groom.offsets):
        raise BadInput("hair and groom are not the same strands", right="in.groom: the groom that is simulated")
    turns = turns_since(groom.points, hair, *roots).turns
    tips = groom.offsets[1:] - 1
    turns[tips] = turns[tips - 1]
    return Normals(np.einsum("pij,pj->pi", turns, rest).astype(np.float32))


LOOKS = 4  # times that bodies are looked at


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
        shifted = False
        for i in range(offsets[s] + 1, offsets[s + 1]):
            y = row(points, i)
            l = length(minus(row(points, i), before))
            before = y
            known = at < len(looked) and looked[at] == i
            deep = known and found.distance[at] < kept[i]
            if shifted or deep:  # What hangs on a shifted point follows; before it nothing changes, to the bit.
                root = row(points, i - 1)
                rate = row(velocities, i - 1)
                shifted = True
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
