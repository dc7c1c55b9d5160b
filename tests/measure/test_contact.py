"""Depths, packing and clumps of hair."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_tuft import measure_tuft
from hairpipe.groom.strands import lay_strands
from hairpipe.levelset.bake import bake
from hairpipe.measure.contact import densities, overlap, relative_speed
from hairpipe.nodes.measure_contact import measure_contact
from hairpipe.nodes.measure_crossing import measure_crossing
from hairpipe.nodes.measure_packing import measure_packing
from hairpipe.values import Strands


def test_depths_are_counted_without_the_roots(sphere):
    ball, other = (bake(sphere(0.05, (x, 0.0, 0.0)), 0.0025, 8.0) for x in (0.0, 0.2))
    away = np.full((200, 3), 1.0, np.float32)
    away[0] = away[100] = 0.0
    one = away.copy()
    one[1], one[2], one[150] = (0.048, 0.0, 0.0), (0.0, 0.045, 0.0), (0.0, 0.0, 0.049)
    both = one.copy()
    both[151:154] = [[0.2, 0.041, 0.0], [0.155, 0.0, 0.0], [0.2, 0.0, 0.051]]
    offsets = np.array([0, 100, 200], np.int32)
    values = {n: Strands(p, p * 0, offsets, 8e-5) for n, p in ((3, away), (4, one), (6, both))}
    frames = tuple(values)
    hair, (first, second) = (
        Frames(frames, values.__getitem__),
        (Frames(frames, dict.fromkeys(frames, s).__getitem__) for s in (ball, other)),
    )
    table = measure_contact(hair, (first, second), None, Time(3, 10.0))
    assert table["time [s]"] == pytest.approx([0.0, 0.1, 0.3])
    assert table["points inside"].tolist() == [0, 3, 5] and table["points"].tolist() == [198] * 3
    assert table["deepest [mm]"] == pytest.approx([0.0, 5.0, 9.0], abs=0.1)
    assert table["99 % quantile [mm]"] == pytest.approx([0.0, 1.03, 5.0], abs=0.15)
    alone = measure_contact(hair, (first,), None, Time(3, 10.0))
    assert alone["points inside"].tolist() == [0, 3, 3]


def test_depth_below_the_band_is_exact_and_not_pinched(sphere):
    ball = bake(sphere(0.05), 0.0025, 8.0)
    before = np.full((3, 3), 1.0, np.float32)
    after = before.copy()
    after[1] = [0.012, 0.0, 0.0]
    values = {n: Strands(p, p * 0, np.array([0, 3], np.int32), 8e-5) for n, p in enumerate((before, after))}
    table = measure_contact(
        Frames((0, 1), values.__getitem__), (Frames((0, 1), {0: ball, 1: ball}.__getitem__),), None, Time(0, 24.0)
    )
    assert table["points inside"].tolist() == [0, 1] and table["points pinched"].tolist() == [0, 0]
    assert table["deepest [mm]"][1] == pytest.approx(38.0, abs=1.0)


def test_strands_that_began_inside_count_once_outside(sphere):
    """Two free points in a ball: one comes out, then the other, then one goes in again."""
    ball = bake(sphere(0.05), 0.0025, 8.0)
    values = {}
    for frame, (first, second) in enumerate([(0.045, 0.04), (0.06, 0.04), (0.06, 0.07), (0.047, 0.07)]):
        points = np.array([[1.0, 0, 0], [first, 0, 0], [second, 0, 0]], np.float32)
        values[frame] = Strands(points, 0 * points, np.array([0, 3], np.int32), 8e-5)
    frames = tuple(values)
    surface = Frames(frames, dict.fromkeys(frames, ball).__getitem__)
    table = measure_contact(Frames(frames, values.__getitem__), (surface,), None, Time(0, 24.0))
    assert table["points still inside"].tolist() == [2, 1, 0, 0] and table["points inside"].tolist() == [0, 0, 0, 1]
    assert table["still inside [mm]"] == pytest.approx([10.0, 10.0, 0.0, 0.0], abs=0.1)
    assert table["deepest [mm]"] == pytest.approx([0.0, 0.0, 0.0, 3.0], abs=0.1)


def test_pinched_points_are_counted_separately(sphere):
    """In the lens where two balls overlap by 20 mm there is no room; on the far side of one there is."""
    left, right = (bake(sphere(0.05, (x, 0.0, 0.0)), 0.0025, 8.0) for x in (-0.04, 0.04))
    before = np.full((4, 3), 1.0, np.float32)
    after = before.copy()
    after[1:3] = [[0.001, 0.0, 0.0], [-0.087, 0.0, 0.0]]
    values = {n: Strands(p, p * 0, np.array([0, 4], np.int32), 8e-5) for n, p in enumerate((before, after))}
    surfaces = tuple(Frames((0, 1), {0: s, 1: s}.__getitem__) for s in (left, right))
    table = measure_contact(Frames((0, 1), values.__getitem__), surfaces, None, Time(0, 24.0))
    assert table["points inside"].tolist() == [0, 1] and table["points pinched"].tolist() == [0, 1]
    assert table["deepest [mm]"] == pytest.approx([0.0, 3.0], abs=0.1)
    assert table["pinched [mm]"] == pytest.approx([0.0, 11.0], abs=0.3)


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


def hanging(tips):
    """Straight strands that hang side by side, at places (S, 2)."""
    roots = np.column_stack([tips[:, 0], 0 * tips[:, 0], tips[:, 1]])
    points = roots[:, None] + np.linspace(0.0, 1.0, 6)[:, None] * [0.0, -0.3, 0.0]
    offsets = np.arange(0, 6 * len(tips) + 1, 6).astype(np.int32)
    flat = points.reshape(-1, 3).astype(np.float32)
    return Strands(flat, flat * 0, offsets, 8e-5)


def test_lattice_chance_and_clumps():
    chance = np.random.default_rng(2)
    side = np.arange(30) * 0.002
    lattice = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    r, angle = 0.03 * np.sqrt(chance.uniform(size=900)), chance.uniform(0, 2 * np.pi, 900)
    strewn = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    pairs = np.repeat(strewn[::2], 2, axis=0) + np.tile([[0.0, 0.0], [1e-4, 0.0]], (450, 1))
    values = {n: hanging(tips) for n, tips in enumerate((lattice, strewn, pairs, 0.5 * strewn))}
    table = measure_tuft(Frames(tuple(values), values.__getitem__), Time(0, 24.0))
    assert table["nearest strand [mm]"][0] == pytest.approx(2.0, rel=1e-4)
    assert table["nearest strand [mm]"][2] == pytest.approx(0.1, rel=0.05)
    assert table["over random [1]"] == pytest.approx([1.95, 1.0, 0.1 / 0.886, 1.0], rel=0.05)
    assert table["spread of tips [mm]"][1] == pytest.approx(0.03e3 / np.sqrt(2), rel=0.03)
    assert table["spread of tips [mm]"][3] == pytest.approx(0.5 * table["spread of tips [mm]"][1], rel=1e-5)


def test_single_strand_is_not_a_tuft():
    values = {1: hanging(np.zeros((1, 2)))}
    with pytest.raises(BadInput, match="a tuft needs more than one strand"):
        measure_tuft(Frames((1,), values.__getitem__), Time(1, 24.0))
    values = {1: hanging(np.zeros((2, 2)))}
    together = measure_tuft(Frames((1,), values.__getitem__), Time(1, 24.0))
    assert together["nearest strand [mm]"].tolist() == [0.0]


def test_hairs_that_lean_across_the_other_lock_have_crossed_it():
    """Two locks of four hairs; one hair of the first crosses all of the second at about 0.55 of its length."""
    side = np.column_stack([[0.0, 1e-3, 2e-3, 3e-3, 0.1, 0.101, 0.102, 0.103], np.zeros(8)])
    apart, leaning = hanging(side), hanging(side)
    points = leaning.points.reshape(8, 6, 3)
    points[2, :, 0] += np.float32(np.linspace(0.0, 0.18, 6))
    values = {1: apart, 2: leaning}
    lock = lay_strands(4, 0.3, 5, (0.0, -1.0, 0.0), (1e-3, 0.0, 0.0), None, 0.0)
    table = measure_crossing(Frames((1, 2), values.__getitem__), lock, Time(1, 24.0))
    levels = np.linspace(0.5, 1.0, 9)
    exact = np.mean([(2e-3 + 0.18 * level > side[4:, 0]).sum() for level in levels]) / 16.0
    assert table["crossed pairs [%]"] == pytest.approx([0.0, 100.0 * exact])
    assert table["crossed hairs [%]"] == pytest.approx([0.0, 100.0 / 8.0])
    with pytest.raises(BadInput, match="4 of 4 strands"):
        measure_crossing(Frames((1,), {1: hanging(side[:4])}.__getitem__), lock, Time(1, 24.0))
