"""Fewer hairs, and hair that follows them."""

from dataclasses import replace

import numpy as np
import pytest
from hairpipe.nodes.follow_guides import follow_guides
from hairpipe.nodes.measure_roots import measure_roots
from hairpipe.nodes.thin_groom import thin_groom

from hairpipe.body.shapes import build_box
from hairpipe.data import Strands
from hairpipe.errors import BadInput
from hairpipe.graph import Frames, Time
from hairpipe.groom.guiding import guides_of
from hairpipe.groom.sampling import take
from hairpipe.groom.strands import lay_strands
from hairpipe.groom.tuft import Tuft, gather_tuft
from hairpipe.scripted_ends.ends import lead
from hairpipe.scripted_ends.track import Track

ROW = lay_strands(4, 0.1, 6, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0)
GROOM = gather_tuft(ROW, Tuft(rows=3, apart=(0.0, 0.0, 0.01), stray=10.0))
TURN = Track(times=(0.0, 1.0), turn=(0.0, 40.0), move=((0.0, 0.0, 0.0), (0.1, 0.2, 0.3)))


def shown(points, groom, velocities=0.0):
    speeds = np.broadcast_to(velocities, points.shape).astype(np.float32)
    return Strands(points.astype(np.float32), speeds, groom.offsets, 8e-5)


def test_every_third_strand_keeps_its_id_and_its_points():
    some = thin_groom(GROOM, every=3)
    assert some.ids.tolist() == [1, 4, 7, 10]
    for n, strand in enumerate(some.ids):
        ours, theirs = (slice(*g.offsets[k : k + 2]) for g, k in ((some, n), (GROOM, strand)))
        assert np.array_equal(some.points[ours], GROOM.points[theirs])
    assert np.array_equal(thin_groom(GROOM, every=1).points, GROOM.points)
    with pytest.raises(BadInput, match="leaves none of 12"):
        thin_groom(GROOM, every=24)


def test_guides_follow_themselves():
    rng = np.random.default_rng(2)
    points = GROOM.points + 0.01 * rng.normal(size=GROOM.points.shape)
    points[GROOM.offsets[:-1]] = GROOM.points[GROOM.offsets[:-1]]
    assert follow_guides(shown(points, GROOM), GROOM, GROOM, None, None).points == pytest.approx(points, abs=1e-7)


def test_velocities_are_the_derivative_of_positions():
    guides, span = thin_groom(GROOM, every=5), 1e-3
    rng = np.random.default_rng(3)
    at, speed = (rng.normal(size=guides.points.shape) for _ in range(2))
    before, now, after = (
        follow_guides(
            shown(at + t * speed, guides, speed), guides, GROOM, None, lead(GROOM, 0.7 + t, TURN, None, None, None)
        )
        for t in (-span, 0.0, span)
    )
    rate = (after.points.astype(float) - before.points.astype(float)) / (2 * span)
    assert now.velocities == pytest.approx(rate, abs=2e-3)
    assert np.abs(now.velocities).max() > 1.0


def test_hair_that_is_moved_with_its_roots_is_right():
    ends = lead(GROOM, 0.7, TURN, None, None, None)
    assert np.abs(ends.roots[0, :, :3] - np.eye(3)).max() > 0.1
    strand = np.repeat(np.arange(12), 7)
    moved, speeds = (
        np.einsum("pij,pj->pi", m[strand, :, :3], GROOM.points) + m[strand, :, 3] for m in (ends.roots, ends.roots_rate)
    )
    guides = thin_groom(GROOM, every=5)
    kept = np.isin(GROOM.ids[strand], guides.ids)
    found = follow_guides(shown(moved[kept], guides, speeds[kept]), guides, GROOM, None, ends)
    assert found.points == pytest.approx(moved, abs=1e-6)
    assert found.velocities == pytest.approx(speeds, abs=1e-6)
    for other in (found, replace(shown(moved[kept], guides), offsets=np.array([0, 6, 14]))):
        with pytest.raises(BadInput, match="not the same strands"):
            follow_guides(other, guides, GROOM, None, ends)


def test_guides_that_share_a_root_follow_themselves():
    fan = replace(ROW, points=ROW.points + 0.01 * np.random.default_rng(4).normal(size=ROW.points.shape))
    fan.points[fan.offsets[:-1]] = 0.0
    assert np.array_equal(guides_of(fan, fan), np.arange(4))


def test_guides_of_any_order_and_ids_are_found_by_their_roots():
    assert np.array_equal(guides_of(ROW, take(ROW, np.array([3, 0]))), [1, 1, 0, 0])
    assert np.array_equal(guides_of(ROW, replace(take(ROW, np.array([3, 0])), ids=np.array([0, 3]))), [1, 1, 0, 0])


def test_two_leads_are_refused():
    ends, body = lead(GROOM, 0.0, TURN, None, None, None), build_box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    with pytest.raises(BadInput, match="both a body and driven ends"):
        follow_guides(shown(GROOM.points, GROOM), GROOM, GROOM, body, ends)
    with pytest.raises(BadInput, match="both a body and driven ends"):
        measure_roots(GROOM, Frames((1,), {1: body}.__getitem__), Frames((1,), {1: ends}.__getitem__), Time(1, 24.0))
