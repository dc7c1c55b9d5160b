"""Cost of hair as a volume: of the grid that key hairs are simulated with, and of hair interpolated between them."""

from collections.abc import Callable

import numba
import numpy as np

from hairpipe.geometry.sorting import morton_order
from hairpipe.graphs.experiments.bench.repeat import repeat
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report
from hairpipe.groom.interpolating import interpolated
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.groom.sampling import thinned
from hairpipe.laws.pressure import SWEEPS, densest, filled_cells, spread
from hairpipe.laws.settings import Pressure, Volume
from hairpipe.values import Groom, Strands
from hairpipe.values.groom import reach_of
from hairpipe.values.strand_arrays import offsets_of
from hairpipe.volume.transfer import deposit, sample_strands
from hairpipe.volume.volume_filter import VolumeFilter

THREADS = (1, 2)
LENGTH, SCALP, PARTING = 0.25, 0.25, 30.0
"""Of a hair [m]; side of the square that roots lie in [m]; see `interpolate_hair` [deg]."""
STEP = 1 / 96
MASS = 1e-6
"""Of time [s]; of a point [kg]."""


def measure_volume(
    echo: Echo, hairs: int = 100_000, segments: int = 50, every: int = 10, seconds: float = 5.0
) -> Report:
    """Measure every case, and report progress.

    hairs     shown
    segments  of each
    every     so many of them one is a key
    seconds   that every measurement is repeated
    """
    groom = scattered_hair(hairs, segments)
    keys = thinned(groom, every)
    echo(f"{len(keys.ids):,} hairs on a grid")
    cases = [*_grid(keys, seconds), *_pressure(keys, seconds)]
    echo(f"{hairs:,} hairs between {len(keys.ids):,} keys")
    return make_report(__name__, {"kernels": [*cases, *_interpolation(groom, keys, segments, seconds)]})


def _grid(keys: Groom, seconds: float) -> list[Case]:
    """Time a step of friction between hairs."""
    points = keys.points.astype(float)
    rng = np.random.default_rng(2)
    masses = np.full(len(points), MASS)
    reach = reach_of(points, keys.offsets)
    grid = VolumeFilter(Volume(), keys.offsets, masses, reach)
    velocities = rng.normal(size=points.shape)
    return _cases("grid", "point and step", lambda: grid.change(points, velocities, STEP), len(points), seconds)


def _pressure(keys: Groom, seconds: float) -> list[Case]:
    """Time the pressure of hair where half of it is too dense."""
    cell = Volume().cell
    points = keys.points.astype(float)
    samples = sample_strands(points, keys.offsets, reach_of(points, keys.offsets), cell)
    assert samples is not None
    grid = deposit(samples, np.full(len(points), MASS), np.zeros(points.shape))
    rest = 0.5 * densest(grid, cell)
    field = np.zeros((*samples.counts, 3))

    def press() -> None:
        spread(grid, field, cell, rest, Pressure().compliance, STEP)

    count = np.count_nonzero(filled_cells(grid[..., 0])) * SWEEPS
    return _cases("pressure", "cell and sweep", press, count, seconds, lambda: field.fill(0.0))


def _interpolation(groom: Groom, keys: Groom, segments: int, seconds: float) -> list[Case]:
    followed = weigh_keys(keys, groom, PARTING)
    bent = scattered_hair(len(keys.ids), segments, seed=1).points
    hair = Strands(bent, np.zeros(bent.shape, np.float32), keys.offsets, 8e-5)
    still = np.tile(np.eye(3, 4), (len(groom.ids), 1, 1)), np.zeros((len(groom.ids), 3, 4))

    def work() -> None:
        interpolated(hair, keys, groom, followed, still)

    return _cases("interpolate", "shown point", work, len(groom.points), seconds)


def _cases(
    kernel: str,
    each: str,
    work: Callable[[], object],
    count: int,
    seconds: float,
    prepare: Callable[[], object] = lambda: None,
) -> list[Case]:
    """Time some work of so many parts, with each number of threads."""
    before = numba.get_num_threads()
    cases = []
    for threads in (n for n in THREADS if n <= before):
        numba.set_num_threads(threads)
        try:
            time = repeat(work, seconds, prepare)
        finally:
            numba.set_num_threads(before)
        spent = time.per(1e-9 * count)
        cases.append({"kernel": kernel, "for each": each, "threads": threads, **spent.columns(" [ns]")})
    return cases


def scattered_hair(hairs: int, segments: int, seed: int = 0) -> Groom:
    """Make hair whose roots lie at random in a square, in Morton order, every one wavy in its own way."""
    rng = np.random.default_rng(seed)
    roots = SCALP * rng.random((hairs, 3)) * (1.0, 0.0, 1.0)
    roots = roots[morton_order(roots)]
    ways = np.array((0.0, -1.0, 0.0)) + 0.2 * np.cumsum(rng.normal(size=(hairs, segments, 3)), axis=1) / 5
    steps = LENGTH / segments * ways / np.linalg.norm(ways, axis=2, keepdims=True)
    points = np.concatenate((roots[:, None], roots[:, None] + np.cumsum(steps, axis=1)), axis=1).reshape(-1, 3)
    offsets = offsets_of(np.full(hairs, segments + 1))
    ids = np.arange(hairs, dtype=np.int32)
    frames = np.concatenate((np.tile(np.eye(3), (hairs, 1, 1)), roots[:, :, None]), axis=2)
    sites = ids, np.tile((1.0, 0.0, 0.0), (hairs, 1))
    return Groom(points, offsets, ids, *sites, frames, np.zeros((hairs, 2), np.float32))
