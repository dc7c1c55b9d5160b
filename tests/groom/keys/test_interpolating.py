"""Hair between keys: it has the lengths that it had, goes rigidly where its keys do, and bends as they bend."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.body.shapes import build_box
from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import probe_union
from hairpipe.groom.interpolating import probe_shell
from hairpipe.groom.key_weights import keys_among, weigh_keys
from hairpipe.groom.sampling import thinned
from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands
from hairpipe.levelset.bake import bake
from hairpipe.nodes.carry_normals import carry_normals
from hairpipe.nodes.interpolate_hair import Clumps, interpolate_hair
from hairpipe.nodes.measure_roots import measure_roots
from hairpipe.nodes.thin_groom import thin_groom
from hairpipe.values import Groom, Mesh, Strands
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take

ROW = lay_strands(4, 0.1, 6, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0)


@pytest.fixture(scope="session")
def groom() -> Groom:
    """Twelve hairs of 6 segments that stray."""
    return gather_tuft(ROW, Tuft(rows=3, apart=(0.0, 0.0, 0.01), stray=10.0))


@pytest.fixture(scope="session")
def keys(groom) -> Groom:
    """Every fifth of them."""
    return thinned(groom, 5)


@pytest.fixture(scope="session")
def row() -> Groom:
    """Four parallel hairs beside each other."""
    return ROW


def strands_at(groom: Groom, points: np.ndarray, velocities: np.ndarray | float = 0.0) -> Strands:
    speeds = np.broadcast_to(velocities, points.shape).astype(np.float32)
    return Strands(np.ascontiguousarray(points, float), speeds, groom.offsets, 8e-5)


@pytest.fixture(scope="session")
def at() -> Callable[..., Strands]:
    """Give a groom's strands at some points."""
    return strands_at


def show(hair, keys, groom, body=None, ends=None, surface=None, parting=30.0, **settings):
    followed = weigh_keys(keys, groom, parting)
    return interpolate_hair(hair, keys, groom, None, body, ends, surface, None, Time(1, 24.0), followed, **settings)


@pytest.fixture(scope="session")
def shown() -> Callable[..., Strands]:
    """Interpolate hair at one frame."""
    return show


@pytest.fixture(scope="session")
def bent() -> Callable[..., np.ndarray]:
    """Bend every strand of a groom without stretching it: each segment is turned at random by up to so many degrees."""

    def bend(groom: Groom, angle: float, seed: int) -> np.ndarray:
        rng = np.random.default_rng(seed)
        axes = rng.normal(size=groom.points.shape)
        axes *= np.radians(angle) * rng.random((len(axes), 1)) / np.linalg.norm(axes, axis=1, keepdims=True)
        points = groom.points.copy()
        for begin, end in zip(groom.offsets, groom.offsets[1:], strict=False):
            turns = Rotation.from_rotvec(axes[begin + 1 : end])
            steps = turns.apply(np.diff(groom.points[begin:end], axis=0))
            points[begin + 1 : end] = points[begin] + np.cumsum(steps, axis=0)
        return points

    return bend


@pytest.fixture(scope="session")
def nameless() -> Callable[[Groom], Groom]:
    """Give hairs other ids, so that none of them is a key."""
    return lambda groom: replace(groom, ids=groom.ids + 1000)


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


def test_any_number_of_threads_gives_the_same_bytes(groom, keys, at, bent, same_on_threads, shown):
    same_on_threads(lambda: shown(at(keys, bent(keys, 60.0, 7), 1.0), keys, groom))


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


def scattered(count, seed):
    """Straight hairs with roots at random in a square of a metre, that go to either side of x = 0."""
    groom = lay_strands(count, 0.1, 3, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), None, 0.0)
    rng = np.random.default_rng(seed)
    roots = np.repeat(rng.uniform(-0.5, 0.5, (count, 3)) * (1.0, 1.0, 0.0), 4, axis=0)
    points = groom.points * np.where(roots[:, :1] > 0.0, 1.0, -1.0) + roots
    return replace(groom, points=points, ids=groom.ids + 1000 * seed)


def test_weights_are_those_of_brute_force():
    keys, groom = scattered(40, 1), scattered(100, 2)
    found = weigh_keys(keys, groom, 60.0)
    for s in range(100):
        root = groom.points[4 * s]
        others = keys.points[::4]
        same_side = (others[:, 0] > 0.0) == (root[0] > 0.0)
        distances = np.where(same_side, np.linalg.norm(others - root, axis=1), np.inf)
        nearest = np.argsort(distances)[:3]
        weights = distances[nearest] ** -2.0
        assert np.array_equal(found.keys[s], nearest)
        assert found.weights[s] == pytest.approx(weights / weights.sum(), rel=1e-9)


def test_keys_across_a_parting_are_not_followed(at, bent, shown):
    keys, groom = scattered(40, 1), scattered(100, 2)
    left = keys.points[keys.offsets[:-1], 0] < 0.0
    hair = np.where(np.repeat(left, 4)[:, None], bent(keys, 90.0, 3), keys.points)
    found = shown(at(keys, hair), keys, groom)
    right = np.repeat(groom.points[groom.offsets[:-1], 0] > 0.0, 4)
    assert found.points[right] == pytest.approx(groom.points[right], abs=1e-14)
    assert np.abs(found.points - groom.points)[~right].max() > 0.01
    beyond = shown(at(keys, hair), keys, groom, parting=180.0)
    assert np.abs(beyond.points - groom.points)[right].max() > 0.01


def test_hair_that_is_like_no_key_follows_the_one_least_unlike(row):
    up = replace(row, points=row.points * (1.0, -1.0, 1.0), ids=row.ids + 9)
    keys = replace(row, points=row.points.copy())
    keys.points[keys.offsets[2] + 1 : keys.offsets[3]] += (0.05, 0.0, 0.0)
    assert np.array_equal(weigh_keys(keys, up, 60.0).keys[:, 0], [2, 2, 2, 2])


def test_keys_that_share_a_root_are_themselves(row):
    fan = replace(row, points=row.points + 0.01 * np.random.default_rng(4).normal(size=row.points.shape))
    fan.points[fan.offsets[:-1]] = 0.0
    assert np.array_equal(weigh_keys(fan, fan, 60.0).own, np.arange(4))


def test_a_key_is_known_by_its_id_and_its_points(row):
    some = take(row, np.array([3, 0]))
    assert np.array_equal(keys_among(row, some), [1, -1, -1, 0])
    assert np.array_equal(keys_among(row, replace(some, ids=np.array([0, 3]))), [-1, -1, -1, -1])
    assert np.array_equal(weigh_keys(replace(some, ids=some.ids + 9), row, 60.0).homes, [3, 0])


def test_one_key_is_followed_by_all(row):
    found = weigh_keys(take(row, np.array([2])), row, 60.0)
    assert np.array_equal(found.keys[:, 0], [0, 0, 0, 0])
    assert np.array_equal(found.weights, [[1.0, 0.0, 0.0]] * 4)


def test_tips_of_parallel_hair_come_as_near_as_they_can(row, at, shown):
    key = take(row, np.array([0]))
    found = shown(at(key, key.points), key, row, clumps=Clumps(pull=1.0, begin=0.5)).points.reshape(4, 7, 3)
    apart = np.linalg.norm(found - found[:1], axis=2)
    assert apart[:, :4] == pytest.approx(np.tile(0.01 * np.arange(4.0)[:, None], (1, 4)), abs=1e-14)
    assert (np.diff(apart[1:, 3:], axis=1) < 0.0).all()
    assert (apart[1:, -1] < 0.3 * apart[1:, 0]).all()
    assert np.array_equal(found[0], key.points)


def test_no_segment_is_stretched_and_velocities_are_the_derivative(groom, keys, at, bent, shown):
    span, here, clumps = 1e-5, bent(keys, 40.0, 5), Clumps()
    speed = np.random.default_rng(6).normal(size=here.shape)
    before, now, after = (
        shown(at(keys, here + t * speed, speed), keys, groom, clumps=clumps) for t in (-span, 0.0, span)
    )
    rest, lengths = (segment_lengths(some.points, groom.offsets) for some in (groom, now))
    theirs = np.repeat(np.isin(groom.ids, keys.ids), 6)
    assert lengths[~theirs] == pytest.approx(rest[~theirs], rel=1e-12)
    assert now.velocities == pytest.approx((after.points - before.points) / (2 * span), abs=1e-4)


def test_no_pull_leaves_hair_as_it_is(groom, keys, at, bent, shown):
    hair = at(keys, bent(keys, 40.0, 7))
    plain, pulled = (shown(hair, keys, groom, clumps=clumps).points for clumps in (None, Clumps(pull=0.0)))
    assert pulled == pytest.approx(plain, abs=1e-15)


RADIUS, VOXEL = 0.05, 0.005
CENTRE = np.array([0.02, -0.07, 0.0])


@pytest.fixture(scope="module")
def surface(sphere):
    """A ball that rises at a metre a second."""
    mesh = sphere(RADIUS, CENTRE, level=4)
    return bake(Mesh(mesh.points, mesh.triangles, np.tile([0.0, 1.0, 0.0], (len(mesh.points), 1))), VOXEL, 8.0)


@pytest.fixture(scope="module")
def curtain():
    """Hairs of 24 segments that hang in a row, those at its ends beside the ball, others in it; the first and last."""
    hair = lay_strands(30, 0.12, 24, (0.0, -1.0, 0.0), (0.006, 0.0, 0.001), None, 0.0)
    hair = replace(hair, points=hair.points - (0.07, 0.0, 0.0))
    return hair, take(hair, np.array([0, 29]))


def heights(points):
    return np.linalg.norm(points - CENTRE, axis=1) - RADIUS


def test_no_point_is_left_inside_and_lengths_stay(curtain, surface, at, shown):
    groom, keys = curtain
    through = shown(at(keys, keys.points), keys, groom)
    found = shown(at(keys, keys.points), keys, groom, None, None, (surface,), thickness=2e-3)
    assert heights(through.points).min() < -0.03
    fifth = np.tile(np.arange(25) >= 5, 30)
    assert heights(found.points)[fifth].min() > 2e-3 - 0.1 * VOXEL
    rest, now = (segment_lengths(some.points, groom.offsets) for some in (groom, found))
    assert now == pytest.approx(rest, rel=1e-12)
    beside = heights(through.points).reshape(30, 25).min(axis=1) > 4e-3
    assert 5 < beside.sum() < 25
    assert np.array_equal(found.points.reshape(30, -1)[beside], through.points.reshape(30, -1)[beside])


def test_pushed_points_move_with_the_body(curtain, surface, at, shown):
    groom, keys = curtain
    found = shown(at(keys, keys.points), keys, groom, None, None, (surface,))
    normals = (found.points - CENTRE) / np.linalg.norm(found.points - CENTRE, axis=1, keepdims=True)
    moved = (found.points != shown(at(keys, keys.points), keys, groom).points).any(axis=1)
    touching = moved & (np.abs(heights(found.points) - 1e-3) < 1e-4)
    assert touching.sum() > 20
    assert (np.einsum("pi,pi->p", found.velocities - (0.0, 1.0, 0.0), normals)[touching] > -0.05).all()


def test_keys_stay_where_they_are(curtain, surface, at, shown):
    groom, _ = curtain
    found = shown(at(groom, groom.points), groom, groom, None, None, (surface,))
    assert np.array_equal(found.points, groom.points)


def test_hair_that_is_bent_into_the_body_comes_out(curtain, surface, at, shown, bent):
    groom, keys = curtain
    for seed in range(3):
        points = bent(keys, 60.0, seed)
        found = shown(at(keys, points), keys, groom, None, None, (surface,), thickness=2e-3)
        others = np.repeat(~np.isin(groom.ids, keys.ids), 25) & np.tile(np.arange(25) >= 5, 30)
        assert heights(found.points)[others].min() > 2e-3 - 0.1 * VOXEL


def test_any_number_of_threads_pushes_alike(curtain, surface, at, same_on_threads, shown):
    groom, keys = curtain
    same_on_threads(lambda: shown(at(keys, keys.points), keys, groom, None, None, (surface,)))


def test_nothing_is_probed_beyond_reach():
    points = np.zeros((3, 3))
    assert np.array_equal(probe_union([], points, np.array([0.1, 0.2, 0.3])).distance, [0.1, 0.2, 0.3])


MIDDLE = np.array([0.015, -0.05, 0.01])


@pytest.fixture(scope="module")
def shell(sphere):
    """A ball that the middle of the groom is in, and its ends within the band of."""
    return bake(sphere(0.04, MIDDLE), 0.005, 8.0, "refuse")


def test_normals_of_a_ball_point_away_from_its_centre(groom, shell):
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(500, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    points = MIDDLE + ways * rng.uniform(0.02, 0.07, (500, 1))
    found = probe_shell(points, shell).normal
    assert np.einsum("pi,pi->p", found, ways).min() > np.cos(np.radians(2.0))
    assert not probe_shell(points + 1.0, shell).normal.any()


def test_hair_that_is_moved_rigidly_turns_its_normals_as_much(groom, at, shell):
    ends = drive(groom, 0.7, TURN, None, None, None)
    motion = ends.roots[0]
    assert np.abs(motion[:, :3] - np.eye(3)).max() > 0.1
    rest = probe_shell(groom.points, shell).normal
    found = carry_normals(at(groom, groom.points @ motion[:, :3].T + motion[:, 3]), groom, shell, None, ends)
    assert found.vectors == pytest.approx(rest @ motion[:, :3].T, abs=1e-6)


def test_a_normal_keeps_its_angle_to_hair_that_bends(groom, at, bent, shell):
    rest, points = probe_shell(groom.points, shell).normal, bent(groom, 40.0, 1)
    found = carry_normals(at(groom, points), groom, shell, None, None).vectors
    inner = np.setdiff1d(np.arange(len(points)), groom.offsets[1:] - 1)
    before, after = (
        np.einsum("pi,pi->p", n[inner], p[inner + 1] - p[inner]) for n, p in ((rest, groom.points), (found, points))
    )
    assert after == pytest.approx(before, abs=1e-7) and np.abs(found - rest).max() > 0.1


def test_other_strands_are_refused(groom, keys, at, shell):
    with pytest.raises(BadInput, match="not the same strands"):
        carry_normals(at(keys, keys.points), groom, shell, None, None)
