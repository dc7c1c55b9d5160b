"""Hair between keys: it has the lengths that it had, goes rigidly where its keys do, and bends as they bend."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.body.shapes import build_box
from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.nodes.measure_roots import measure_roots
from hairpipe.nodes.thin_groom import thin_groom
from hairpipe.values.groom import segment_lengths

TURN = Track(times=(0.0, 1.0), turn=(0.0, 40.0), move=((0.0, 0.0, 0.0), (0.1, 0.2, 0.3)))


def test_keys_are_shown_as_they_were_simulated(groom, keys, at, shown):
    rng = np.random.default_rng(2)
    hair = at(keys, keys.points + 0.01 * rng.normal(size=keys.points.shape), rng.normal(size=keys.points.shape))
    found = shown(hair, keys, groom)
    strand = np.repeat(groom.ids, np.diff(groom.offsets))
    theirs = np.isin(strand, keys.ids)
    assert np.array_equal(found.points[theirs], hair.points)
    assert np.array_equal(found.velocities[theirs], hair.velocities)


def test_hair_that_stands_where_a_key_does_is_turned_as_it_is(groom, keys, at, bent, nameless, shown):
    points = bent(keys, 170.0, 3)
    assert shown(at(keys, points), keys, nameless(keys)).points == pytest.approx(points, abs=1e-14)


@pytest.mark.parametrize("angle", [20.0, 180.0])
def test_no_segment_is_stretched(angle, groom, keys, at, bent, shown):
    points = bent(keys, angle, 4) if angle < 180.0 else -keys.points  # every segment upside down: no smallest rotation
    found = shown(at(keys, points), keys, groom)
    rest, now = (segment_lengths(some, groom.offsets) for some in (groom.points, found.points))
    assert now == pytest.approx(rest, rel=1e-12)


def test_velocities_are_the_derivative_of_positions(groom, keys, at, bent, shown):
    span, here = 1e-5, bent(keys, 60.0, 5)
    speed = np.random.default_rng(6).normal(size=here.shape)
    before, now, after = (
        shown(at(keys, here + t * speed, speed), keys, groom, None, drive(groom, 0.7 + t, TURN, None, None, None))
        for t in (-span, 0.0, span)
    )
    rate = (after.points - before.points) / (2 * span)
    assert now.velocities == pytest.approx(rate, abs=1e-4)
    assert np.abs(now.velocities).max() > 1.0


def test_hair_that_is_moved_with_its_roots_is_right(groom, keys, at, nameless, shown):
    ends = drive(groom, 0.7, TURN, None, None, None)
    assert np.abs(ends.roots[0, :, :3] - np.eye(3)).max() > 0.1
    strand = np.repeat(np.arange(12), 7)
    moved, speeds = (
        np.einsum("pij,pj->pi", m[strand, :, :3], groom.points) + m[strand, :, 3] for m in (ends.roots, ends.roots_rate)
    )
    kept = np.isin(groom.ids[strand], keys.ids)
    found = shown(at(keys, moved[kept], speeds[kept]), keys, nameless(groom), None, ends)
    assert found.points == pytest.approx(moved, abs=1e-13)
    assert found.velocities == pytest.approx(speeds, abs=1e-6)


def test_hair_of_fewer_segments_follows_the_same_arc(at, shown):
    """Straight keys that become arcs of a circle: hair beside them becomes the same arc, to second order."""
    errors = []
    for segments in (7, 14):
        key, hair = (lay_strands(1, 0.2, n, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0) for n in (40, segments))

        def arc(share):
            return 0.1 * np.stack([1.0 - np.cos(2.0 * share), -np.sin(2.0 * share), 0.0 * share], axis=1)

        points = shown(at(key, arc(np.linspace(0.0, 1.0, 41))), key, replace(hair, ids=hair.ids + 9)).points
        errors.append(np.abs(points - arc(np.linspace(0.0, 1.0, segments + 1))).max())
    assert errors[0] < 2e-3 and errors[1] < errors[0] / 3.0


def test_any_number_of_threads_gives_the_same_bytes(groom, keys, at, bent, threads, shown):
    found = []
    for count in (1, 2):
        threads(count)
        hair = shown(at(keys, bent(keys, 60.0, 7), 1.0), keys, groom)
        found.append(hair.points.tobytes() + hair.velocities.tobytes())
    assert found[0] == found[1]


def test_other_strands_and_two_leads_are_refused(groom, keys, at, shown):
    with pytest.raises(BadInput, match="not the same strands"):
        shown(at(groom, groom.points), keys, groom)
    ends, body = drive(groom, 0.0, TURN, None, None, None), build_box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    with pytest.raises(BadInput, match="both a body and driven ends"):
        shown(at(groom, groom.points), groom, groom, body, ends)
    with pytest.raises(BadInput, match="both a body and driven ends"):
        measure_roots(
            groom, Frames((1,), {1: body}.__getitem__), Frames((1,), {1: ends}.__getitem__), Time(1, 24.0), ()
        )


def test_every_third_strand_keeps_its_id_and_its_points(groom):
    some = thin_groom(groom, every=3)
    assert some.ids.tolist() == [1, 4, 7, 10]
    for n, strand in enumerate(some.ids):
        ours, theirs = (slice(*g.offsets[k : k + 2]) for g, k in ((some, n), (groom, strand)))
        assert np.array_equal(some.points[ours], groom.points[theirs])
    assert np.array_equal(thin_groom(groom, every=1).points, groom.points)
    with pytest.raises(BadInput, match="removes all 12"):
        thin_groom(groom, every=24)
