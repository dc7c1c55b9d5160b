"""Cost of hair as a volume: of hair that is interpolated between key hairs."""

from collections.abc import Callable
from typing import NamedTuple

import numba
import numpy as np

from hairpipe.bench.machine import Machine, this_machine
from hairpipe.bench.repeat import Spread, repeat
from hairpipe.data import Groom, Strands
from hairpipe.groom.keys.interpolating import interpolated
from hairpipe.groom.keys.key_weights import weigh_keys
from hairpipe.groom.sampling import thinned
from hairpipe.groom.strand_arrays import offsets_of
from hairpipe.spatial.morton import morton_order

THREADS = (1, 2)
LENGTH, SCALP, PARTING = 0.25, 0.25, 30.0
"""Of a hair [m]; side of the square that roots lie in [m]; see `interpolate_hair` [deg]."""


class Sizes(NamedTuple):
    """What is measured, and for how long.

    hairs     shown
    segments  of each
    every     so many of them one is a key
    seconds   that every measurement is repeated
    """

    hairs: int = 100_000
    segments: int = 50
    every: int = 10
    seconds: float = 5.0


FULL = Sizes()


class Case(NamedTuple):
    """One kernel with so many threads; its time per shown point [ns]."""

    kernel: str
    threads: int
    time: Spread


class Report(NamedTuple):
    """All of it."""

    machine: Machine
    sizes: Sizes
    cases: list[Case]


def measure_volume(say: Callable[[str], None], sizes: Sizes = FULL) -> Report:
    """Measure every case, and report progress."""
    groom = scattered_hair(sizes)
    keys = thinned(groom, sizes.every)
    say(f"{sizes.hairs:,} hairs between {len(keys.ids):,} keys")
    followed = weigh_keys(keys, groom, PARTING)
    bent = scattered_hair(sizes._replace(hairs=len(keys.ids)), seed=1).points
    hair = Strands(bent, np.zeros(bent.shape, np.float32), keys.offsets, 8e-5)
    still = np.tile(np.eye(3, 4), (sizes.hairs, 1, 1)), np.zeros((sizes.hairs, 3, 4))
    before, cases = numba.get_num_threads(), []
    for threads in (count for count in THREADS if count <= before):
        numba.set_num_threads(threads)
        try:
            time = repeat(lambda: interpolated(hair, keys, groom, followed, still), sizes.seconds)
        finally:
            numba.set_num_threads(before)
        cases.append(Case("interpolate", threads, time.per(1e-9 * len(groom.points))))
    return Report(this_machine(), sizes, cases)


def scattered_hair(sizes: Sizes, seed: int = 0) -> Groom:
    """Make hair whose roots lie at random in a square, in Morton order, every one wavy in its own way."""
    rng = np.random.default_rng(seed)
    roots = SCALP * rng.random((sizes.hairs, 3)) * (1.0, 0.0, 1.0)
    roots = roots[morton_order(roots)]
    ways = np.array((0.0, -1.0, 0.0)) + 0.2 * np.cumsum(rng.normal(size=(sizes.hairs, sizes.segments, 3)), axis=1) / 5
    steps = LENGTH / sizes.segments * ways / np.linalg.norm(ways, axis=2, keepdims=True)
    points = np.concatenate((roots[:, None], roots[:, None] + np.cumsum(steps, axis=1)), axis=1).reshape(-1, 3)
    offsets, ids = offsets_of(np.full(sizes.hairs, sizes.segments + 1)), np.arange(sizes.hairs, dtype=np.int32)
    frames = np.concatenate((np.tile(np.eye(3), (sizes.hairs, 1, 1)), roots[:, :, None]), axis=2)
    sites = ids, np.tile((1.0, 0.0, 0.0), (sizes.hairs, 1))
    return Groom(points, offsets, ids, *sites, frames, np.zeros((sizes.hairs, 2), np.float32))
