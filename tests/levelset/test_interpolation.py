"""The body between two frames: what each scheme promises, and what it costs."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from hairpipe.levelset import sample
from hairpipe.levelset.bake import bake
from hairpipe.values import LevelSet, Mesh

DT = 1 / 24
VOXEL = 0.05
SEMI_AXES = np.array([0.6, 0.45, 0.3])


def fibonacci(count: int) -> np.ndarray:
    """Directions spread evenly."""
    i = np.arange(count) + 0.5
    z, turn = 1 - 2 * i / count, i * np.pi * (3 - np.sqrt(5))
    return np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)


class Ellipsoid:
    """An ellipsoid that travels and turns about z at a steady rate, baked at the frames 0 and 1."""

    def __init__(self, sphere, travel=(0.0, 0.0, 0.0), degrees=0.0, half_width=10.0):
        self.travel, self.turn, self.mesh = np.array(travel), np.radians(degrees), sphere(level=5)
        self.fields = tuple(sample.field_of(self.baked(a, half_width)) for a in (0.0, 1.0))

    def pose(self, a):
        return Rotation.from_rotvec([0, 0, a * self.turn]), a * self.travel

    def velocity(self, points, a):
        return (self.travel + np.cross([0, 0, self.turn], points - a * self.travel)) / DT

    def baked(self, a, half_width) -> LevelSet:
        rotation, shift = self.pose(a)
        points = rotation.apply(self.mesh.points * SEMI_AXES) + shift
        return bake(Mesh(points, self.mesh.triangles, self.velocity(points, a)), VOXEL, half_width)

    def surface(self, a, count=300):
        """Points on the surface at time a, with their normals."""
        rotation, shift = self.pose(a)
        directions = fibonacci(count)
        normals = directions / SEMI_AXES
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return rotation.apply(directions * SEMI_AXES) + shift, rotation.apply(normals)

    def phi(self, scheme, a, points):
        return np.array([sample.distance_between(int(scheme), *self.fields, a, DT, *point) for point in points])

    def read(self, what, scheme, a, point):
        return what(*self.fields, sample.departure_points(int(scheme), *self.fields, a, DT, *point))

    def error(self, scheme, a):
        """Largest |phi| on the true surface [circumradius]."""
        return np.abs(self.phi(scheme, a, self.surface(a)[0])).max() / SEMI_AXES.max()


@pytest.fixture(scope="module")
def still(sphere):
    return Ellipsoid(sphere)


@pytest.fixture(scope="module")
def travelling(sphere):
    """By its own largest radius in a frame."""
    return Ellipsoid(sphere, travel=(0.6, 0, 0), half_width=14.0)


@pytest.fixture(scope="module")
def turning(sphere):
    return Ellipsoid(sphere, degrees=30.0)


@pytest.mark.parametrize("scheme", list(sample.Interpolation))
def test_a_body_at_rest_stays(still, scheme):
    points = np.random.default_rng(0).uniform(-1, 1, (200, 3))
    rest = np.array([sample.distance(still.fields[0], *point) for point in points])
    assert np.allclose(still.phi(scheme, 0.37, points), rest, atol=1e-7)


@pytest.mark.parametrize("scheme", [sample.Interpolation.two_sided, sample.Interpolation.linear])
def test_at_the_frames_it_is_what_was_baked(travelling, turning, scheme):
    points = np.random.default_rng(0).uniform(-1.2, 1.2, (300, 3))
    for body in (travelling, turning):
        for a, field in ((0.0, body.fields[0]), (1.0, body.fields[1])):
            baked = np.array([sample.distance(field, *point) for point in points])
            assert np.allclose(body.phi(scheme, a, points), baked, atol=1e-6)
            assert np.allclose(body.phi(scheme, abs(a - 1e-9), points), baked, atol=1e-6)


def test_one_sided_begins_with_the_frame_before_and_misses_the_one_after(turning):
    points = np.random.default_rng(0).uniform(-0.7, 0.7, (300, 3))
    before, after = (np.array([sample.distance(field, *point) for point in points]) for field in turning.fields)
    assert np.allclose(turning.phi(sample.Interpolation.one_sided, 0.0, points), before, atol=1e-6)
    assert np.abs(turning.phi(sample.Interpolation.one_sided, 1.0, points) - after).max() > VOXEL / 2


def test_a_body_that_travels_by_its_radius_keeps_its_shape_two_sided(travelling):
    # Linear interpolation loses it between the frames.
    errors = {scheme.name: travelling.error(scheme, 0.5) for scheme in sample.Interpolation}
    floor = (
        np.abs([sample.distance(travelling.fields[0], *p) for p in travelling.surface(0.0)[0]]).max() / SEMI_AXES.max()
    )
    assert errors["two_sided"] < max(1.3 * floor, 0.006)
    assert errors["one_sided"] < 0.02
    assert errors["linear"] > 0.1


def test_rigid_travel_is_exact_but_for_the_samples(travelling):
    # Read where the frames agree to the last bit, the two ends of the travel are the same place on the body.
    points, normals = travelling.surface(0.25)
    for offset in (-0.05, 0.0, 0.1):
        carried = points + offset * normals
        here = [sample.distance(travelling.fields[0], *point) for point in carried - 0.25 * travelling.travel]
        there = [sample.distance(travelling.fields[1], *point) for point in carried + 0.75 * travelling.travel]
        assert np.allclose(travelling.phi(0, 0.25, carried), 0.75 * np.array(here) + 0.25 * np.array(there), atol=1e-5)


def test_the_normal_is_the_bodys_and_that_of_the_distance(travelling, turning):
    # Degrees from the body's normal, and from the gradient of the distance.
    for body, off_body, off_phi in ((travelling, 2.0, 2.0), (turning, 6.0, 8.0)):
        points, normals = body.surface(0.5)
        found = np.array([body.read(sample.normal_at, 0, 0.5, point) for point in points])
        assert np.allclose(np.linalg.norm(found, axis=1), 1)
        e = 0.5 * VOXEL * np.eye(3)
        slope = np.stack([body.phi(0, 0.5, points + n) - body.phi(0, 0.5, points - n) for n in e], axis=1)
        slope /= np.linalg.norm(slope, axis=1, keepdims=True)
        assert np.degrees(np.arccos(np.clip((found * normals).sum(axis=1), -1, 1))).max() < off_body
        assert np.degrees(np.arccos(np.clip((found * slope).sum(axis=1), -1, 1))).max() < off_phi


@pytest.mark.parametrize(("scheme", "off"), [("two_sided", 0.1), ("linear", 0.2), ("one_sided", 0.27)])
def test_the_velocity_is_the_bodys(travelling, turning, scheme, off):
    # One-sided keeps the direction of the frame before, 15 degrees ago: sin(15 degrees) = 0.26.
    scheme = sample.Interpolation[scheme]
    for body, most in ((travelling, 1e-5), (turning, off)):
        points, _ = body.surface(0.5)
        found = np.array([body.read(sample.velocity_at, scheme, 0.5, point) for point in points])
        exact = body.velocity(points, 0.5)
        assert np.linalg.norm(found - exact, axis=1).max() < most * np.linalg.norm(exact, axis=1).max()


def test_missing_velocity_of_a_frame_is_that_of_the_other(sphere):
    # The body leaves the band of its first frame: half the velocity would carry the second frame only half the way.
    body = Ellipsoid(sphere, travel=(1.2, 0, 0), half_width=6.0)

    def front(a):
        return brentq(
            lambda x: sample.distance_between(0, *body.fields, a, DT, x, 0.0, 0.0), 0.3 + 1.2 * a, 0.9 + 1.2 * a
        )

    assert front(0.9) == pytest.approx(0.6 + 1.2 * 0.9, abs=0.02)
