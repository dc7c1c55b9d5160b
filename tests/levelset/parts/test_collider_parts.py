"""A body in parts between two frames, and the path of a pose."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import FirstHit, SdfSample, Walk
from hairpipe.graphs.experiments.studies.interpolation.bodies import FRAME, outline_at, parts_of, poses_at, surfaces_of
from hairpipe.graphs.experiments.studies.interpolation.cases import CASES, Case
from hairpipe.graphs.experiments.studies.interpolation.solids import ellipsoid
from hairpipe.graphs.experiments.studies.interpolation.surface_errors import misses
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_parts import build_collider_parts, part_poses_at, path_between
from hairpipe.values import Mesh
from hairpipe.values.body import gathered

VOXEL, HALF_WIDTH = 0.05, 8.0
STILL = np.eye(3, 4)[None]


@cache
def surfaces_in(name: str):
    """The surfaces of the case of a name, which several tests look at."""
    return surfaces_of({case.name: case for case in CASES}[name], VOXEL, HALF_WIDTH)


def error(surface, case: Case, a: float) -> float:
    """The largest error of a surface over the body's radius."""
    off, _ = misses(surface, outline_at(case, a), a * FRAME, VOXEL * HALF_WIDTH)
    return off.max() / case.radius


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_between_frames_nothing_but_the_samples_own_error_is_left(case):
    surfaces = surfaces_in(case.name)
    floor = max(error(surfaces["parts"], case, a) for a in (0.0, 1.0))
    for a in (0.25, 0.5, 0.8):
        assert error(surfaces["parts"], case, a) < 1.02 * floor + 5e-4
    if "turn" in case.name or len(case.solids) > 1:
        assert error(surfaces["two_sided"], case, 0.5) > 4.0 * floor


@pytest.mark.parametrize("case", [CASES[3], CASES[7]], ids=lambda case: case.name)
def test_normal_and_velocity_are_those_of_the_body(case):
    surface = surfaces_in(case.name)["parts"]
    poses, rates = poses_at(case, 0.4)
    last = len(case.solids) - 1
    points = case.solids[last].mesh().points @ poses[last][:, :3].T + poses[last][:, 3]
    if last:
        other = case.solids[0]
        points = points[~other._replace(semi=1.3 * other.semi).contains(points)]
    probe = SdfSample.blank(len(points))
    surface.probe(points, 0.4 * FRAME, probe)
    exact = (points - poses[last][:, 3]) @ (rates[last][:, :3] @ poses[last][:, :3].T).T + rates[last][:, 3]
    fastest = np.linalg.norm(exact, axis=1).max()
    assert np.linalg.norm(probe.velocity - exact, axis=1).max() < 1e-6 * fastest
    assert fastest <= surface.speed < 3.0 * fastest  # that of corners of boxes
    away = SdfSample.blank(len(points))
    surface.probe(points + 0.5 * VOXEL * probe.normal, 0.4 * FRAME, away)
    assert np.allclose(away.distance - probe.distance, 0.5 * VOXEL, rtol=0.1)


@pytest.fixture(scope="module")
def swelling():
    """A ball that grows from 0.5 to 0.6 m in a frame, at rest."""
    return build_collider_parts(
        *(gathered(("ball",), STILL, 0.0 * STILL, [bake(ball(r), VOXEL, HALF_WIDTH)]) for r in (0.5, 0.6)), FRAME
    )


def ball(radius: float) -> Mesh:
    return ellipsoid((radius, radius, radius)).mesh()


def test_a_part_that_changes_its_shape_is_blended_and_pushes(swelling):
    points = ball(0.55).points[::11].copy()
    probe = SdfSample.blank(len(points))
    swelling.probe(points, 0.5 * FRAME, probe)
    outwards = points / 0.55
    assert np.allclose(probe.distance, 0.0, atol=0.05 * VOXEL)
    assert np.allclose(probe.normal, outwards, atol=0.03)
    assert np.allclose(probe.velocity, 0.1 / FRAME * outwards, atol=0.04 * 0.1 / FRAME)
    assert swelling.speed == pytest.approx(0.1 / FRAME, rel=0.02)


def test_velocity_is_how_the_distance_changes(swelling):
    # d phi / dt = -v . n |grad phi|, and the gradient of a distance is 1.
    travel = surfaces_in(CASES[5].name)["parts"]
    for surface, case_points in ((swelling, ball(0.56).points), (travel, outline_at(CASES[5], 0.5))):
        points = case_points[::13].copy()
        e = 1e-4 * FRAME
        probes = [SdfSample.blank(len(points)) for _ in range(3)]
        for probe, seconds in zip(probes, (0.5 * FRAME - e, 0.5 * FRAME, 0.5 * FRAME + e), strict=True):
            surface.probe(points, seconds, probe)
        slope = (probes[2].distance - probes[0].distance) / (2 * e)
        along = (probes[1].velocity * probes[1].normal).sum(axis=1)
        off = np.abs(slope + along) / np.abs(along).max()
        assert off.mean() < 0.02 and off.max() < 0.12


def test_a_point_at_rest_is_met_by_a_part_that_swells(swelling):
    points = np.array([[0.57, 0.0, 0.0], [0.0, 0.64, 0.0]])
    sweep = FirstHit.blank(2)
    swelling.sweep(Walk(points, points, np.full(2, 0.01), *np.full((2, 2), -np.inf)), 0.0, FRAME, sweep)
    assert sweep.fraction[0] == pytest.approx(0.6, abs=0.03) and np.isinf(sweep.fraction[1])


def test_frames_with_other_parts_are_refused():
    case = CASES[0]
    parts = parts_of(case, [bake(case.solids[0].mesh(), VOXEL, HALF_WIDTH)], 0.0)
    other = gathered(("other",), parts.poses, parts.rates, [bake(case.solids[0].mesh(), VOXEL, HALF_WIDTH)])
    with pytest.raises(BadInput, match="not the same at both frames"):
        build_collider_parts(parts, other, FRAME)


def pose(t):
    """A motion without any symmetry, [R | p] at times in frames, (3, 4)."""
    turn = Rotation.from_rotvec([0.3 * np.sin(t), 0.8 * t, 0.2 * t * t]) * Rotation.from_rotvec([0.5 * t, 0.0, 0.4])
    return np.column_stack([turn.as_matrix(), [np.sin(t), t * t, 0.3 - t]])


def rate(t, e=1e-5):
    return (pose(t + e) - pose(t - e)) / (2 * e * FRAME)


def path(t):
    """The path from frame t to t + 1."""
    return path_between(*(np.array([f(s)]) for s in (t, t + 1) for f in (pose, rate)), FRAME)


def stance(t, a):
    return part_poses_at(path(t), np.array([a * FRAME]))


@pytest.mark.parametrize("a", [0.0, 1.0])
def test_it_goes_through_the_frames_as_they_are(a):
    now = stance(0.0, a)
    assert np.allclose(now.turns[0, 0], pose(a)[:, :3], atol=1e-14)
    assert np.allclose(now.places[0, 0], pose(a)[:, 3], atol=1e-14)
    assert np.allclose(now.drifts[0, 0], rate(a)[:, 3], atol=1e-12)
    W = rate(a)[:, :3] @ pose(a)[:, :3].T
    assert np.allclose(now.spins[0, 0], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-7)


def test_velocities_are_those_of_the_path_and_do_not_jump_at_a_frame():
    e = 1e-6
    for t, a in ((0.0, 0.2), (0.0, 0.5), (0.0, 0.9), (1.0, 0.4)):
        before, now, after = stance(t, a - e), stance(t, a), stance(t, a + e)
        slope = (after.turns - before.turns)[0, 0] / (2 * e * FRAME)
        W = slope @ now.turns[0, 0].T
        assert np.allclose(now.spins[0, 0], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-6)
        assert np.allclose(now.drifts, (after.places - before.places) / (2 * e * FRAME), atol=1e-6)
    end, begin = stance(0.0, 1.0), stance(1.0, 0.0)
    for one, other in zip(end[1:], begin[1:], strict=True):  # but the time since the first frame
        assert np.allclose(one, other, atol=1e-7)


def test_its_error_falls_with_the_fourth_power_of_the_interval():
    def worst(step):
        found = path_between(*(np.array([f(s)]) for s in (0.3, 0.3 + step) for f in (pose, rate)), FRAME * step)
        middle = part_poses_at(found, np.array([0.5 * FRAME * step]))
        true = pose(0.3 + 0.5 * step)
        return np.abs(middle.turns[0, 0] - true[:, :3]).max(), np.abs(middle.places[0, 0] - true[:, 3]).max()

    for coarse, fine in zip(worst(0.4), worst(0.2), strict=True):
        assert 12.0 < coarse / fine < 20.0


def test_a_steady_turn_and_a_parabola_are_exact():
    w = np.array([0.2, 0.9, -0.4])

    def at(a):
        return np.column_stack([Rotation.from_rotvec(w * a).as_matrix(), [a, a * a, 0.0]])

    rates = [(at(a + 1e-5) - at(a - 1e-5)) / (2e-5 * FRAME) for a in (0.0, 1.0)]
    found = path_between(at(0.0)[None], rates[0][None], at(1.0)[None], rates[1][None], FRAME)
    times = np.linspace(0.0, 1.0, 7)
    now = part_poses_at(found, times * FRAME)
    assert np.allclose(now.turns[:, 0], [at(a)[:, :3] for a in times], atol=1e-9)
    assert np.allclose(now.places[:, 0], [at(a)[:, 3] for a in times], atol=1e-9)
