"""Every moving surface: near at the right distance, with the right velocity, and nothing runs through it."""

from collections.abc import Callable

import numba
import numpy as np
import pytest

from hairpipe.geometry.collider import STEEPEST, Collider, FirstHit, SdfSample, Walk, Wander
from hairpipe.graphs.experiments.studies.interpolation.bodies import FRAME, outline_at, poses_at, surfaces_of
from hairpipe.graphs.experiments.studies.interpolation.cases import CASES, Case, Way, moved
from hairpipe.graphs.experiments.studies.interpolation.solids import ellipsoid
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field, sweep_field
from hairpipe.levelset.collider_parts import build_collider_parts, sweep_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.levelset.sphere_tracing import MARGIN
from hairpipe.values import Mesh
from hairpipe.values.body import gathered

VOXEL, HALF_WIDTH = 0.05, 8.0
SCHEMES = ("linear", "one_sided", "two_sided", "parts")
TRAVEL = CASES[0]
BOX = 0.3, 0.012, 0.3
"""Extent of a thin plate of 2.4 voxels [m]."""


@pytest.fixture(scope="module")
def travel() -> dict[str, Collider]:
    return surfaces_of(TRAVEL, VOXEL, HALF_WIDTH)


@pytest.fixture(scope="module", params=[None, 30.0], ids=["travels", "turns, too"])
def plate(request, box) -> tuple[Callable[[float], np.ndarray], dict[str, Collider]]:
    """A thin plate that moves by 6 cm in a frame, its pose, and its surfaces; only parts follow where it turns."""
    way = Way(travel=(0.0, 0.06, 0.0), turn=(request.param or 0.0, 0.0, 0.0))
    case = Case("plate", (), lambda a: way.pose(a)[None], 1.0)
    mesh = box(-0.5 * np.array(BOX), 0.5 * np.array(BOX))
    shape = bake(mesh, 0.005, HALF_WIDTH)
    found: dict[str, Collider] = {
        "parts": build_collider_parts(*(gathered(("plate",), *poses_at(case, a), [shape]) for a in (0.0, 1.0)), FRAME)
    }
    if request.param is None:
        speed = np.tile([0.0, 0.06 / FRAME, 0.0], (len(mesh.points), 1))
        whole = [bake(Mesh(mesh.points + way.pose(a)[:, 3], mesh.triangles, speed), 0.005, 8.0) for a in (0.0, 1.0)]
        found |= {s: build_collider_field(*whole, FRAME, Interpolation[s]) for s in ("two_sided", "one_sided")}
    return way.pose, found


def walk(before: np.ndarray, after: np.ndarray, thickness: float = 1e-3) -> Walk:
    """Ways of which nothing is known."""
    return Walk(before, after, np.full(len(before), thickness), *np.full((2, len(before)), -np.inf))


def crossing(pose, start: float, end: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Ways through the plate, from one side of it to the other, in frames start to end."""
    chance = np.random.default_rng(0)
    ends = [chance.uniform(-0.09, 0.09, (count, 3)) for _ in range(2)]
    side = np.where(chance.random(count) < 0.5, 1.0, -1.0)
    for local, sign in zip(ends, (side, -side), strict=True):
        local[:, 1] = sign * chance.uniform(0.008, 0.2, count)
    before, after = (x @ pose(a)[:, :3].T + pose(a)[:, 3] for x, a in zip(ends, (start, end), strict=True))
    return before, after


@pytest.mark.parametrize("name", SCHEMES)
def test_a_way_whose_ends_are_known_is_swept_as_one_of_which_nothing_is(travel, name):
    surface, chance = travel[name], np.random.default_rng(6)
    start, end, before = 0.3 * FRAME, 0.4 * FRAME, chance.uniform(-1.5, 1.5, (20_000, 3))
    ways = walk(before, before + chance.normal(scale=0.1, size=before.shape))
    ends = [SdfSample.blank(len(before), surface.band) for _ in range(2)]
    surface.probe(ways.before, start, ends[0])
    surface.probe(ways.after, end, ends[1])
    found = [FirstHit.blank(len(before)) for _ in range(2)]
    surface.sweep(ways, start, end, found[0])
    surface.sweep(ways._replace(begin=ends[0].distance, finish=ends[1].distance), start, end, found[1])
    np.testing.assert_array_equal(found[1].fraction, found[0].fraction)
    change = np.linalg.norm(ways.after - before, axis=1) + surface.speed * (end - start)
    left_out = ends[0].distance + ends[1].distance - 2.0 * ways.thickness > MARGIN * change
    assert left_out.mean() > 0.2 and (found[0].fraction <= 1.0).sum() > 40


def test_no_distance_changes_by_more_than_the_way_past_the_body_allows(travel):
    surface, chance = travel["parts"], np.random.default_rng(7)
    before = chance.uniform(-1.5, 1.5, (20_000, 3))
    for step in (0.0, 0.02, 0.2):
        wander = Wander(
            before, 0.3 * FRAME, before + step * chance.normal(size=before.shape), 0.5 * FRAME, np.arange(20_000)
        )
        ways, ends = np.zeros(len(before)), [SdfSample.blank(len(before), surface.band) for _ in range(2)]
        surface.approach(wander, ways)
        surface.probe(wander.before, wander.then, ends[0])
        surface.probe(wander.after, wander.now, ends[1])
        near = ends[1].distance < surface.band
        assert near.sum() > 100 and np.isfinite(ways).all()
        assert (np.abs(ends[1].distance - ends[0].distance) <= STEEPEST * ways + 1e-9)[near].all()


@pytest.mark.parametrize("name", SCHEMES)
def test_beyond_reach_only_the_distance_is_found(travel, name):
    surface, points = travel[name], np.random.default_rng(5).uniform(-2.0, 2.0, (3000, 3))
    for seconds in (0.4 * FRAME, FRAME):
        whole, some = SdfSample.blank(len(points)), SdfSample.blank(len(points))
        surface.probe(points, seconds, whole)
        surface.probe(points, seconds, some, np.full(len(points), 2.0 * VOXEL))
        near = whole.distance < 2.0 * VOXEL
        assert near.any() and (np.isfinite(whole.distance) & ~near).any()
        assert (whole.distance[np.isfinite(whole.distance)] < surface.band).all()
        np.testing.assert_array_equal(some.distance, whole.distance)
        for found, asked in zip(whole[1:], some[1:], strict=True):
            np.testing.assert_array_equal(asked, np.where(near[:, None], found, 0.0))


def test_a_body_that_jumps_is_as_fast_as_that_for_any_velocities(sphere):
    meshes = [sphere(0.5, centre=(x, 0.0, 0.0), level=3) for x in (0.0, 0.2)]
    surface = build_collider_field(*(bake(mesh, VOXEL, HALF_WIDTH) for mesh in meshes), FRAME, Interpolation.two_sided)
    assert surface.speed == pytest.approx(0.2 / FRAME, rel=0.02)


def test_no_point_of_many_runs_through_a_thin_plate(plate):
    pose, surfaces = plate
    before, after = crossing(pose, 0.25, 0.5, 100_000)
    for name, surface in surfaces.items():
        if name != "parts":
            before, after = before[:20_000], after[:20_000]
        sweep = FirstHit.blank(len(before))
        surface.sweep(walk(before, after), 0.25 * FRAME, 0.5 * FRAME, sweep)
        assert np.isfinite(sweep.fraction).all()
        met = before + sweep.fraction[:, None] * (after - before)
        heights = [
            abs(((x - pose(a)[:, 3]) @ pose(a)[:, :3])[1]) - 0.5 * BOX[1]
            for x, a in zip(met[:300], 0.25 + 0.25 * sweep.fraction[:300], strict=True)
        ]
        assert np.allclose(heights, 1e-3, atol=2e-4)


def test_paths_past_or_from_inside_a_body_have_no_hit(plate):
    pose, surfaces = plate
    apart = np.array([[0.0, 0.1, 0.0], [0.3, 0.1, 0.0], [5.0, 5.0, 5.0], [0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
    goal = np.array([[0.1, 0.12, 0.0], [0.3, -0.1, 0.0], [-5.0, 5.0, 5.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.0]])
    local = [x @ pose(a)[:, :3].T + pose(a)[:, 3] for x, a in ((apart, 0.5), (goal, 0.6))]
    for surface in surfaces.values():
        sweep = FirstHit.blank(len(apart))
        surface.sweep(walk(*local), 0.5 * FRAME, 0.6 * FRAME, sweep)
        assert np.isinf(sweep.fraction).all()


def test_resting_points_are_stopped_inward_and_free_outward(plate):
    pose, surfaces = plate
    rest = np.array([[0.0, 0.5 * BOX[1] + 4e-4, 0.0]] * 2)
    goal = np.array([[0.0, -0.05, 0.0], [0.0, 0.05, 0.0]])
    before, after = rest @ pose(0.5)[:, :3].T + pose(0.5)[:, 3], goal @ pose(0.6)[:, :3].T + pose(0.6)[:, 3]
    for surface in surfaces.values():
        sweep = FirstHit.blank(2)
        surface.sweep(walk(before, after), 0.5 * FRAME, 0.6 * FRAME, sweep)
        assert sweep.fraction[0] < 0.02 and np.isinf(sweep.fraction[1])


def test_a_point_that_explodes_is_followed_to_the_body_and_no_farther(travel):
    far = np.array([[1e9, 0.0, 0.0], [0.0, np.inf, 0.0], [-1e9, 1e9, 0.0]])
    for surface in travel.values():
        sweep = FirstHit.blank(3)
        surface.sweep(walk(np.array([[-5.0, 0.0, 0.0]] * 3), far, 0.0), 0.0, FRAME, sweep)
        assert sweep.fraction[0] == pytest.approx(4.4e-9, rel=1e-2) and np.isinf(sweep.fraction[1:]).all()


def test_at_the_end_of_a_frame_a_body_is_what_it_is_just_before(travel):
    """Only its own level set is read there, where both are read before."""
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (3000, 3))
    for name in ("linear", "two_sided"):
        before, at_end = (SdfSample.blank(len(points)) for _ in range(2))
        travel[name].probe(points, np.nextafter(FRAME, 0.0), before)
        travel[name].probe(points, FRAME, at_end)
        near = before.distance < 0.99 * HALF_WIDTH * VOXEL
        assert near.sum() > 100
        for found, expected in zip(at_end, before, strict=True):
            assert found[near] == pytest.approx(expected[near], abs=1e-9)


def test_results_do_not_depend_on_threads_and_a_union_is_one_after_the_other(travel):
    chance = np.random.default_rng(1)
    points, goal = chance.uniform(-1.5, 1.5, (2, 3000, 3))
    other = surfaces_of(moved("other", (ellipsoid((0.3, 0.3, 0.3)), Way(rest=(0.0, 1.0, 0.0)))), VOXEL, HALF_WIDTH)
    for name, surface in travel.items():
        found = []
        for threads, order in (
            (1, (surface, other[name])),
            (min(2, numba.config.NUMBA_NUM_THREADS), (other[name], surface)),
        ):
            numba.set_num_threads(threads)
            probe, sweep = SdfSample.blank(len(points)), FirstHit.blank(len(points))
            for one in order:
                one.probe(points, 0.3 * FRAME, probe)
                one.sweep(walk(points, goal), 0.3 * FRAME, 0.6 * FRAME, sweep)
            found.append([*probe, *sweep])
        assert all(np.array_equal(one, two) for one, two in zip(*found, strict=True))
        alone = SdfSample.blank(len(points))
        surface.probe(points, 0.3 * FRAME, alone)
        assert (found[0][0] <= alone.distance).all() and (found[0][0] < alone.distance).any()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_beyond_its_reach_a_probe_stays_unchanged(travel, scheme):
    points = np.array([[9.0, 0.0, 0.0], [0.6 + 0.3, 0.0, 0.0], [np.nan, 0.0, 0.0]])
    probe = SdfSample.blank(3)
    travel[scheme].probe(points, 0.5 * FRAME, probe)
    assert np.isfinite(probe.distance).tolist() == [False, True, False]
    assert not probe.normal[[0, 2]].any() and not probe.velocity[[0, 2]].any()
    near = SdfSample.blank(3, reach=0.01)
    travel[scheme].probe(points + np.array([0.05, 0.0, 0.0]), 0.5 * FRAME, near)
    assert (near.distance == 0.01).all()


@pytest.mark.parametrize("scheme", ["linear", "two_sided", "parts"])
def test_nothing_jumps_at_a_frame(scheme):
    # From one pair of frames to the next, on a path that turns and accelerates.
    way = Way(turn=(10.0, 20.0, 30.0), travel=(0.3, 0.1, 0.0), extra=(0.2, 0.0, 0.1))
    pairs = []
    for first in (0.0, 1.0):
        case = moved("either", (ellipsoid((0.6, 0.45, 0.3)), way))
        pairs.append(
            surfaces_of(case._replace(path=lambda a, s=first: way.pose(a + s)[None]), VOXEL, HALF_WIDTH)[scheme]
        )
    points = outline_at(moved("either", (ellipsoid((0.6, 0.45, 0.3)), way)), 1.0)[::7]
    points = points * np.random.default_rng(0).uniform(0.8, 1.2, (len(points), 1))
    probes = [SdfSample.blank(len(points)) for _ in pairs]
    for pair, seconds, probe in zip(pairs, (FRAME, 0.0), probes, strict=True):
        pair.probe(points, seconds, probe)
    assert np.isfinite(probes[0].distance).mean() > 0.9
    assert np.allclose(probes[0].distance, probes[1].distance, atol=1e-6)


def test_kernels_of_sweeps_are_kept_for_the_next_process(travel):
    points = np.zeros((1, 3))
    for surface in travel.values():
        surface.sweep(walk(points, points), 0.0, FRAME, FirstHit.blank(1))
    # Numba keeps no kernel with an address of this process in it, such as that of a function passed to another.
    assert not any(
        code.library.has_dynamic_globals for kernel in (sweep_field, sweep_parts) for code in kernel.overloads.values()
    )
