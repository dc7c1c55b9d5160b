"""Motion of a body from rest to the first pose of a shot, so that hair does not start inside it.

Every joint turns against its parent, and a root in the world, on the smooth path

    L(t) = L_rest exp(h01(t / T) r) exp(g(t) w),   r = log(L_rest^T L_first),   g(t) = U h11(1 - (T - t) / U)

over T, with Hermite's h01 = 3 a^2 - 2 a^3 and h11 = a^3 - a^2; places likewise. The last factor is a run-up of U at
most, after which the joint has the velocity w that it begins the shot with: rest and first pose are met to the bit, and
the path is C1 at both.
"""

import numpy as np

from hairpipe.body.rigid import invert
from hairpipe.body.so3 import exponential, logarithm
from hairpipe.data import Body, Pose, Skeleton

RUN_UP = 0.25
"""Longest time over which the velocity of the first pose is reached [s]."""
_INSTANT = 1e-4  # [s]; rates are differences over this time


def approach(rest: Body, first: Pose, before: float, over: float) -> Pose:
    """Return the pose so long before the first one [s], which is come to from rest over some time [s]. Pure."""
    times = [before + t for t in (_INSTANT, 0.0, -_INSTANT)]
    early, now, late = (placed(rest.skeleton, first, t, over) for t in times)
    rates = (late - early) / (2.0 * _INSTANT)
    if rest.shapes is None or first.weights is None or first.weight_rates is None:
        return Pose(now, rates)
    still = rest.shapes.rest
    way = first.weights - still
    past, present, future = (still + s * way + r * first.weight_rates for s, r in (shares(t, over) for t in times))
    return Pose(now, rates, present, (future - past) / (2.0 * _INSTANT))


def shares(before: float, over: float) -> tuple[float, float]:
    """Return the share of the way h01, and the run-up g [s], so long before the first pose [s]. Pure."""
    a = min(max(1.0 - before / over, 0.0), 1.0)
    up = min(RUN_UP, over)
    b = max(1.0 - before / up, 0.0)
    return a * a * (3.0 - 2.0 * a), up * b * b * (b - 1.0)


def placed(skeleton: Skeleton, first: Pose, before: float, over: float) -> np.ndarray:
    """Return the joint-to-world matrices of that pose [m], (J, 4, 4). Pure."""
    share, run = shares(before, over)
    result = np.empty_like(first.transforms)
    for joint, parent in enumerate(skeleton.parents):
        rest, end, rate = skeleton.rest[joint], first.transforms[joint], first.rates[joint]
        if parent >= 0:
            back = invert(first.transforms[parent])
            rate = back @ (rate - first.rates[parent] @ back @ end)
            rest = invert(skeleton.rest[parent]) @ rest
            end = back @ end
        spin = end[:3, :3].T @ rate[:3, :3]
        turn = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
        local = np.eye(4)
        local[:3, :3] = rest[:3, :3] @ exponential(share * logarithm(rest[:3, :3].T @ end[:3, :3]))
        local[:3, :3] = local[:3, :3] @ exponential(run * turn)
        local[:3, 3] = rest[:3, 3] + share * (end[:3, 3] - rest[:3, 3]) + run * rate[:3, 3]
        result[joint] = result[parent] @ local if parent >= 0 else local
    return result
