"""Packing of hair, compared with counting one by one and with hair in order."""

import numpy as np
import pytest

from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.measure.contact import densities, overlap, relative_speed
from hairpipe.nodes.measure_packing import measure_packing
from hairpipe.values import Strands

CELL, NEAR = 0.006, 0.004


def hair(rng, strands=30, most=7):
    counts = rng.integers(2, most, strands)
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    points = rng.uniform(-0.01, 0.01, (offsets[-1], 3)).astype(np.float32)
    return Strands(points, rng.normal(size=points.shape).astype(np.float32), offsets, 8e-5)


def measured(now, reference, **settings):
    frames = (1, 2)
    given = Frames(frames, lambda _: now), Frames(frames, lambda _: reference)
    return measure_packing(*given, **settings)


def test_neighbours_are_those_that_brute_force_finds():
    some = hair(np.random.default_rng(3))
    strand = np.repeat(np.arange(30), np.diff(some.offsets))
    free = [k for k in range(len(strand)) if k not in some.offsets]
    points, speeds, squares = some.points.astype(float), some.velocities.astype(float), []
    for k in free:
        others = [m for m in free if strand[m] != strand[k]]
        away = [np.linalg.norm(points[m] - points[k]) for m in others]
        if min(away) <= NEAR:
            squares.append(np.sum((speeds[others[int(np.argmin(away))]] - speeds[k]) ** 2))
    assert 10 < len(squares) < len(free)
    assert relative_speed(some, NEAR) == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-12)


def test_density_is_what_counting_sample_by_sample_gives():
    some = hair(np.random.default_rng(4))
    sums: dict[tuple, float] = {}
    for begin, end in zip(some.offsets, some.offsets[1:], strict=False):
        for a, b in zip(
            some.points[begin : end - 1].astype(float), some.points[begin + 1 : end].astype(float), strict=True
        ):
            pieces = int(np.linalg.norm(b - a) / CELL) + 1
            for q in range(pieces):
                place = tuple(np.floor((a + (q + 0.5) / pieces * (b - a)) / CELL).astype(int))
                sums[place] = sums.get(place, 0.0) + float(np.linalg.norm(b - a)) / pieces
    density, length = densities(some, CELL)
    assert length.sum() == pytest.approx(sum(sums.values()), rel=1e-12)
    assert np.unique(density.round(3)) == pytest.approx(np.unique(np.round(np.array([*sums.values()]) / CELL**3, 3)))
    assert np.sum(length / density) == pytest.approx(len(sums) * CELL**3, rel=1e-12)


def test_hair_in_order_takes_the_room_that_it_fills():
    side = 0.001 + 0.002 * np.arange(12)  # 3 x 3 strands a cell of 6 mm
    x, z = (grid.ravel() for grid in np.meshgrid(side, side))
    points = np.stack([np.column_stack([x, y + 0 * x, z]) for y in (0.0003, 0.0119)], axis=1).reshape(-1, 3)
    offsets = np.arange(0, 2 * len(x) + 1, 2).astype(np.int32)
    lattice = Strands(points.astype(np.float32), np.zeros((len(points), 3), np.float32), offsets, 8e-5)
    table = measured(lattice, lattice, cell=CELL, near=NEAR)
    assert table["volume [l]"] == pytest.approx([1e3 * 4 * 4 * 2 * CELL**3])
    assert table["density 99 % [km/l]"] == pytest.approx([1e-6 * 9 * 0.0058 / CELL**3], rel=1e-4)
    assert table["nearest strand [mm]"] == pytest.approx([2.0], rel=1e-4)
    assert table["neighbours [m/s]"].tolist() == [0.0] and table["strand error [% of length]"].tolist() == [0.0]
    assert table["overlap [1]"] == pytest.approx([1.0])


def test_histograms_overlap_by_length():
    thin, dense = np.array([1.5]), np.array([1.5, 100.0])
    assert overlap((thin, np.ones(1)), (dense, np.array([3.0, 1.0]))) == pytest.approx(0.75)
    assert overlap((thin, np.ones(1)), (100.0 * thin, np.ones(1))) == 0.0


def test_frames_and_strands_must_correspond():
    rng = np.random.default_rng(5)
    with pytest.raises(BadInput, match="no frames"):
        measured(hair(rng), hair(rng), skip=2)
    with pytest.raises(BadInput, match="do not correspond"):
        measured(hair(rng), hair(rng, strands=4))
