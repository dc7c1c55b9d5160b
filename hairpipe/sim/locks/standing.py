"""Particles of hairs that are simulated again: about their axis, as they stand about it at rest."""

from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.data import Strands
from hairpipe.data.hair import HairState
from hairpipe.groom.keys.key_turns import turned, turns_since
from hairpipe.kernels.vec3 import cross, minus, mix, plus, row
from hairpipe.sim.axis import axis_of
from hairpipe.sim.boundary import Lead, motion_of_roots, place
from hairpipe.sim.hair_model import HairModel


def stand_up(
    hair: HairModel, state: HairState, points: np.ndarray, velocities: np.ndarray, who: np.ndarray, lead: Lead
) -> HairState:
    """Return the state with the particles of some strands, (S,) bool, about axes that they have been carried to; pure.

    points, velocities  of the axes of all [m], [m/s], (P, 3)

    Those beside an axis turn with its segments, twist carried along from the root; the held ones go with the root.
    Nothing is known of accelerations and tensions: strands restart.
    """
    if not who.any():
        return state
    groom, layout = hair.groom, hair.layout
    motions = motion_of_roots(lead, groom)
    turns = turns_since(groom.points, Strands(points, velocities, layout.offsets, hair.diameter), *motions)
    x, v = (values.copy() for values in place(lead, groom, hair.rest, layout))
    _place_beside(axis_of(layout), hair.rest, points, velocities, turns, x, v)
    rows = np.repeat(who[layout.strands], np.diff(layout.first), axis=0)[:, None]
    arrays = {
        "positions": np.where(rows, x, state.positions),
        "velocities": np.where(rows, v, state.velocities).astype(state.velocities.dtype),
        "accelerations": np.where(rows, 0.0, state.accelerations).astype(state.accelerations.dtype),
        "tensions": np.where(rows, 0.0, state.tensions).astype(state.tensions.dtype),
    }
    return replace(state, **arrays, fresh=state.fresh | who[layout.strands])


@njit(cache=True, parallel=True)
def _place_beside(axis, rest, points, velocities, turns, x, v):
    """Write the rows of particles from the root on, in place: those between two points go with the middle of these."""
    for block in prange(len(axis.first) - 1):
        first, end, stride = axis.first[block] + axis.root, axis.first[block + 1], axis.stride
        for lane in range(axis.strands.shape[1]):
            begin, last = axis.offsets[axis.strands[block, lane]], axis.offsets[axis.strands[block, lane] + 1] - 1
            for p in range(first, end):
                k = min((p - first) // stride, last - begin)
                on, after = k * stride == p - first, min(begin + k + 1, last)
                share = 0.0 if on or after == begin + k else 0.5
                middle = mix(row(points, begin + k), row(points, after), share)
                speed = mix(row(velocities, begin + k), row(velocities, after), share)
                was = _of_lane(rest, first + k * stride, lane)
                then = _of_lane(rest, first + (after - begin) * stride, lane)
                segment = min(begin + k, last - 1)
                way = turned(turns.turns, segment, minus(_of_lane(rest, p, lane), mix(was, then, share)))
                at, goes = plus(middle, way), plus(speed, cross(row(turns.spins, segment), way))
                for c in range(3):
                    x[p, c, lane], v[p, c, lane] = at[c], goes[c]


@njit(cache=True)
def _of_lane(lanes, p, lane):
    return lanes[p, 0, lane], lanes[p, 1, lane], lanes[p, 2, lane]
