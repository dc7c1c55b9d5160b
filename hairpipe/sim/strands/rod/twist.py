"""Twists of a rod's vertices, as a solve and a held tip change them; see `frames.py`."""

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import any_lane, either, load, maximum, select, store
from hairpipe.kernels.simd_arrays import difference
from hairpipe.kernels.vec3 import cross, dot, plus, scaled
from hairpipe.sim.strands.rod.frames import BEFORE, FOLDED, GHOST, SPAN, TWIST, across, frame_at, transport, unit_of

_SHORTEST = 1e-30


@inlined
def predict(model, T, span, stays):
    """Extrapolate twists at the rate of the last stage, except in lanes where they are fixed, in place.

    A solve linearised at the initial twists of its stage is of first order.
    """
    last = load(T, (0, SPAN))
    goes = select(either(stays, last <= 0.0), 0.0, span / maximum(last, _SHORTEST))
    for p in range(GHOST + 1, T.shape[0] - 2):
        twist = load(T, (p, TWIST))
        store(T, (p, TWIST), twist + goes * (twist - load(T, (p, BEFORE))))
        store(T, (p, BEFORE), twist)  # The rate of this stage, by which the next one predicts.
    store(T, (0, SPAN), 0.0 * last + span)


@inlined
def follow_solve(model, block, at, dx, b, h):
    """Change twists by the rotation of edges in a solve, to first order, in place: the next solve is linearised there.

    dpsi = kb/2 . (de/|e| + df/|f|) + dth_f - dth_e
    """
    x, T = at.x, at.T
    s = h * load(model.scale, (block, 0))  # Unknowns are angles times a length.
    for p in range(GHOST, x.shape[0] - 3):
        te, ie = unit_of(difference(x, p, p + 1))
        tf, jf = unit_of(difference(x, p + 1, p + 2))
        over = plus(scaled(ie, difference(dx, p, p + 1)), scaled(jf, difference(dx, p + 1, p + 2)))
        writhed = dot(cross(te, tf), over) / maximum(1.0 + dot(te, tf), FOLDED)
        turned = s * (load(b, (p + 1, 3)) - load(b, (p, 3)))
        store(T, (p + 1, TWIST), load(T, (p + 1, TWIST)) + (writhed + turned))


@njit(cache=True, error_model="numpy")
def hold_tip(model, block, x, T, held):
    """Set the remaining twist of the last vertex where the tip is held, in place."""
    if len(held) > 0:
        fixed = load(held, (block,)) > 0.0
        if any_lane(fixed):
            _hold_tip(x, T, fixed)


@njit(cache=True, error_model="numpy")
def _hold_tip(x, T, fixed):
    """Compare the last director with what q' shows; the nearest of the twists that differ by turns is taken."""
    last = x.shape[0] - 3
    (te, tf), _, (m, _) = frame_at(x, T, GHOST)
    for p in range(GHOST + 1, last):  # The tip's director depends on all twists: frames are carried from the root.
        (te, tf), _, (m, _) = frame_at(x, T, p)
    over = transport(m, te, tf)
    shown = across(difference(x, last + 1, last + 2), tf)
    rows = np.empty((2, x.shape[2]), x.dtype)
    store(rows, (0,), dot(cross(over, shown), tf))
    store(rows, (1,), dot(over, shown))
    for lane in range(x.shape[2]):  # Lane by lane: arctan2 has no vector form here, and is needed once a strand only.
        before = T[last, TWIST, lane]
        change = np.arctan2(rows[0, lane], rows[1, lane]) - before
        rows[0, lane] = before + change - 2.0 * np.pi * np.round(change / (2.0 * np.pi))
    store(T, (last, TWIST), select(fixed, load(rows, (0,)), load(T, (last, TWIST))))
