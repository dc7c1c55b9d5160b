"""Particles of hairs that are simulated again: about their axis, as they stand about it at rest."""

from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.data import Strands
from hairpipe.data.hair import HairState
from hairpipe.groom.keys.key_turns import turned, turns_since
from hairpipe.kernels.simd_arrays import copied
from hairpipe.kernels.vec3 import cross, minus, mix, plus, row
from hairpipe.sim.axis import axis_of
from hairpipe.sim.boundary import Driver, clamp_at, motion_of_roots
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.locks.guides import GuideMotion


def motion_along(hair: HairModel, points: np.ndarray, velocities: np.ndarray, driver: Driver) -> GuideMotion:
    """Return the motion of all strands, with axes at points [m], (P, 3), and velocities [m/s]; pure."""
    strands = Strands(points, velocities, hair.layout.offsets, hair.diameter)
    turns = turns_since(hair.groom.points, strands, *motion_of_roots(driver, hair.groom))
    return GuideMotion(points, velocities, turns.turns, turns.spins)


def stand_up(hair: HairModel, state: HairState, motion: GuideMotion, active: np.ndarray, driver: Driver) -> HairState:
    """Return the state with the particles of some strands, (S,) bool, rebuilt about their moving axes; pure.

    Particles off an axis rotate with its segments, the twist transported from the root; held particles move with the
    root. Accelerations and tensions are unknown: strands restart.
    """
    layout = hair.layout
    names = ("positions", "velocities", "accelerations", "tensions")
    arrays = {name: copied(getattr(state, name)) for name in names}
    clamp = clamp_at(driver, hair.groom, hair.rest, layout)
    held = clamp.positions, clamp.velocities
    _stand(axis_of(layout), hair.rest, active, motion, held, tuple(arrays.values()))
    return replace(state, **arrays, fresh=state.fresh | active[layout.strands])


@njit(cache=True, parallel=True)
def _stand(axis, rest, active, motion, held, particles):
    """Write the rows of strands that stand up, in place: those between two points go with the middle of these."""
    (held_x, held_v), (x, v, accelerations, tensions) = held, particles
    for block in prange(len(axis.first) - 1):
        first = axis.first[block]
        end = axis.first[block + 1]
        for lane in range(axis.strands.shape[1]):
            if active[axis.strands[block, lane]]:
                accelerations[first:end, :, lane] = 0.0  # Nothing is known of either: the strand restarts.
                tensions[first:end, :, lane] = 0.0
                x[first : first + axis.root, :, lane] = held_x[block, : axis.root, :, lane]
                v[first : first + axis.root, :, lane] = held_v[block, : axis.root, :, lane]
                _place_beside(axis, rest, motion, block, lane, x, v)


@njit(cache=True)
def _place_beside(axis, rest, motion, block, lane, x, v):
    """Write the rows of one strand from the root on, in place."""
    first = axis.first[block] + axis.root
    end = axis.first[block + 1]
    stride = axis.stride
    begin = axis.offsets[axis.strands[block, lane]]
    last = axis.offsets[axis.strands[block, lane] + 1] - 1
    for p in range(first, end):  # A row between two points stands about their middle, turned as the segment is.
        k = min((p - first) // stride, last - begin)
        on = k * stride == p - first
        after = min(begin + k + 1, last)
        share = 0.0 if on or after == begin + k else 0.5
        middle = mix(row(motion.points, begin + k), row(motion.points, after), share)
        speed = mix(row(motion.velocities, begin + k), row(motion.velocities, after), share)
        was = _of_lane(rest, first + k * stride, lane)
        then = _of_lane(rest, first + (after - begin) * stride, lane)
        segment = min(begin + k, last - 1)
        way = turned(motion.turns, segment, minus(_of_lane(rest, p, lane), mix(was, then, share)))
        at = plus(middle, way)
        goes = plus(speed, cross(row(motion.spins, segment), way))
        for c in range(3):
            x[p, c, lane], v[p, c, lane] = at[c], goes[c]


@njit(cache=True)
def _of_lane(lanes, p, lane):
    return lanes[p, 0, lane], lanes[p, 1, lane], lanes[p, 2, lane]
