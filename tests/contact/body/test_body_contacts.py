"""Hair on a ball and in a hull: nothing inside, Coulomb's cone, a soft start, and a gentle way out."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.contact.body import PUSH_OUT, STRAIN, pushes, rise, within_reach
from hairpipe.contact.body_implicit import DEEP, FREE, INSIDE, NEW, TOUCHES, ContactState
from hairpipe.geometry.collider import SdfSample
from hairpipe.geometry.rotations import root_frames
from hairpipe.laws.settings import Air, Drag, Scheme, StepControl, StrainLimit
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Mesh

from ...strand_scenes import even_ball

CENTRE, RADIUS = np.array([0.04, -0.06, -0.0333]), 0.05


@pytest.fixture(scope="module")
def ball():
    return bake(even_ball(CENTRE, RADIUS, 600), 0.004, 6.0)


def still(surface):
    return [build_collider_field(surface, surface, 1 / 24, Interpolation.two_sided)]


def _depth(points):
    return RADIUS - np.linalg.norm(points - CENTRE, axis=1)


def test_hair_dropped_on_a_ball_stays_outside_and_comes_to_rest(scene, straight, ball):
    s = scene([straight(0.1, 20, [1, 0.1, 0.05 * k]) for k in range(-2, 3)], drag=5.0)
    for _ in range(30):
        s.run(1 / 24, bodies=still(ball))
        assert _depth(s.axis).max() < 1e-4
    assert _depth(s.axis).max() > -4e-3
    s.run(1.0, bodies=still(ball))
    assert np.abs(s.hair.layout.axis(s.state.velocities)).max() < 0.05


def test_hair_that_starts_inside_leaves_without_a_burst(scene, straight, ball):
    s = scene([straight(0.08, 16, [1, -0.7, 0])])
    assert _depth(s.axis).max() > 0.004
    fastest = 0.0
    for _ in range(24):
        s.run(1 / 24, bodies=still(ball))
        fastest = max(fastest, np.abs(s.state.velocities).max())
    assert _depth(s.axis).max() < 1e-3
    assert fastest < 5.0


@pytest.mark.parametrize("velocity", ["trapezoid", "full_step"])
def test_the_nine_steps_hold_what_lies_on_a_body(scene, straight, ball, velocity):
    """Else step 7 would give it what gravity and the hair that hangs down beside do in a step."""
    step = 1 / 240
    s = scene([straight(0.25, 50, [1, 0.1, 0])], step=step, drag=5.0, scheme=Scheme("nine_steps", velocity=velocity))
    for _ in range(12):
        s.run(1 / 24, bodies=still(ball))
    away = s.axis - CENTRE
    far = np.linalg.norm(away, axis=1)
    touching = far < RADIUS + 0.8e-3
    assert touching.sum() > 5
    speeds = np.sum(s.hair.layout.axis(s.state.velocities) * away, axis=1) / far
    assert np.abs(speeds[touching]).max() < 0.1 * 9.81 * step


def test_a_body_that_comes_carries_the_hair_away(scene, straight, ball):
    """At 0.5 m/s the ball goes by where the hair hangs."""
    s = scene([straight(0.1, 20, [0, -1, 0])])
    speed = np.array([0.5, 0.0, 0.0])
    moved = [replace(ball, origin=ball.origin + np.array([-0.1 + k * speed[0] / 24, 0, 0])) for k in range(8)]
    moving = [replace(m, velocity=np.full(m.velocity.shape, speed, np.float32)) for m in moved]
    for k in range(7):
        s.run(1 / 24, bodies=[build_collider_field(moving[k], moving[k + 1], 1 / 24, Interpolation.two_sided)])
        centre = CENTRE + np.array([-0.1 + (k + 1) * speed[0] / 24, 0, 0])
        assert (RADIUS - np.linalg.norm(s.axis - centre, axis=1)).max() < 5e-4


def test_a_body_that_comes_before_the_first_frame_has_no_hair_in_it_there(scene, straight, ball):
    """Pre-roll: it comes smoothly from 12 cm away in half a second. Else it has half of the hair in it."""
    hanging = [straight(0.1, 20, [0.1 * k, -1, 0]) for k in (-1, 0, 1)]
    at_once, led = scene(hanging), scene(hanging)
    assert (_depth(at_once.axis) > 1e-3).sum() > 20
    away = np.array([-0.12, 0.0, 0.0])
    share = np.linspace(0.0, 1.0, 13)
    moved = [replace(ball, origin=ball.origin + (1 - s * s * (3 - 2 * s)) * away) for s in share]
    rates = [-away * 6 * s * (1 - s) * 2.0 for s in share]
    moving = [
        replace(m, velocity=np.full(m.velocity.shape, rate, np.float32)) for m, rate in zip(moved, rates, strict=True)
    ]
    for before, after in pairwise(moving):
        led.run(1 / 24, bodies=[build_collider_field(before, after, 1 / 24, Interpolation.two_sided)])
    assert (_depth(led.axis) > 1e-3).sum() == 0


RADII = np.array([0.72, 0.5, 0.4])
SEGMENTS = 12


class Hull:
    """An ellipsoid of 1.44 m, and hair of 6 to 19 cm on it whose roots lie at some depth; all of it so many times."""

    def __init__(self, sphere, scale, depth, seed, place=(0.0, 0.0, 0.0), voxel=0.02):
        rng = np.random.default_rng(seed)
        self.turn, self.place, self.scale = Rotation.random(random_state=seed), np.asarray(place), scale
        unit = sphere(level=3)
        points = np.ascontiguousarray(self.turn.apply(unit.points * RADII * scale))  # kernels are compiled for C order
        self.mesh = Mesh(points + self.place, unit.triangles)
        surface = bake(self.mesh, voxel * scale, 3.0)
        self.bodies = [build_collider_field(surface, surface, 1 / 24, Interpolation.two_sided)]
        triangles = rng.choice(len(unit.triangles), 8, replace=False).astype(np.int32)
        corners = self.mesh.points[unit.triangles[triangles]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        ways = normals + rng.normal(0.0, 0.5, (8, 3))
        ways *= (scale * rng.uniform(0.06, 0.19, 8) / np.linalg.norm(ways, axis=1))[:, None]
        roots = corners.mean(axis=1) - scale * rng.uniform(*depth, 8)[:, None] * normals
        points = roots[:, None] + np.linspace(0.0, 1.0, SEGMENTS + 1)[:, None] * ways[:, None]
        middles = np.full((8, 3), 1 / 3)
        frames = root_frames(self.mesh.points, unit.triangles, triangles, middles)
        offsets, ids = (np.arange(9) * (SEGMENTS + 1)).astype(np.int32), np.arange(8, dtype=np.int32)
        groom = Groom(points.reshape(-1, 3), offsets, ids, triangles, middles, frames, np.zeros((8, 2), np.float32))
        self.hair = build_hair(groom, Material(), "network")

    def run(self, scene, frames):
        """Give the state of every frame."""
        state = start(self.hair, self.mesh, scene)
        for _ in range(frames):
            state = advance_frame(self.hair, state, (self.mesh, self.mesh), self.bodies, 1 / 24, scene)
            yield state

    def speeds(self, state):
        return np.linalg.norm(self.hair.layout.axis(state.velocities), axis=1)

    def distances(self, points):
        """From the body, as it is measured and as it is, but for the flatness of its triangles."""
        probe = SdfSample.blank(len(points))
        self.bodies[0].probe(np.ascontiguousarray(points), 0.0, probe)
        return probe.distance


@pytest.mark.parametrize(
    ("scheme", "scale", "depth", "seed"),
    [
        ("tr_bdf2", 1.0, (0.02, 0.1), 1),
        ("tr_bdf2", 0.1, (0.02, 0.1), 2),
        ("tr_bdf2", 10.0, (0.02, 0.1), 3),
        ("tr_bdf2", 1.0, (0.0, 0.01), 4),
        ("bdf2", 1.0, (0.02, 0.1), 5),
        ("backward_euler", 1.0, (0.02, 0.1), 6),
        ("nine_steps", 1.0, (0.02, 0.1), 7),
    ],
)
def test_hair_with_roots_deep_in_a_still_body_comes_to_rest(sphere, scheme, scale, depth, seed):
    """Weightless, lest it fall: all that it has is what it was pushed with, and that is lost."""
    hull = Hull(sphere, scale, depth, seed, place=scale * np.array([0.3, -1.0, 2.0]))
    scene = Scene(0.0, Air(Drag(8.0)), steps=StepControl(longest=1 / 96), strain=StrainLimit(), scheme=Scheme(scheme))
    speeds = [hull.speeds(state) for state in hull.run(scene, 24)]
    fastest, energies = [s.max() for s in speeds], [np.square(s).sum() for s in speeds]
    assert max(fastest) < 3.0 * PUSH_OUT
    assert max(energies[-3:]) < 0.5 * max(energies[:6])
    assert scheme == "nine_steps" or fastest[-1] < 0.8 * PUSH_OUT


def test_depth_is_exact_below_the_band(sphere):
    """To a fraction of the blocks of 8 cm, of which only the corners are known; a band ends at 3 cm."""
    hull = Hull(sphere, 1.0, (0.0, 0.01), 5, voxel=0.01)
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (4000, 3)) * RADII
    deep = points[np.linalg.norm(points / RADII, axis=1) < 0.9][:60]
    exact = np.array([_nearest(x) for x in deep])
    off = np.abs(hull.distances(hull.turn.apply(deep) + hull.place) + exact)
    assert np.median(exact) > 0.1 and exact.max() > 0.2
    assert np.median(off) < 0.01 and off.max() < 0.04


def _nearest(x):
    """Distance to the ellipsoid from inside, over many points of it."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, 181), np.linspace(0, 2 * np.pi, 361), indexing="ij")
    unit = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    return np.linalg.norm(unit * RADII - x, axis=-1).min()


def test_all_that_pushes_a_strand_strains_it_a_little():
    offsets, axial = np.array([0, 3, 5], np.int32), np.array([0.2, 0.1])
    masses = np.array([np.inf, 1e-7, 3e-7, np.inf, 5e-7])
    push = pushes(axial, masses, offsets)
    assert [push[1] * 4e-7, push[4] * 5e-7] == pytest.approx(STRAIN * axial)


def test_no_point_keeps_more_than_the_one_before_lets_it():
    segments = np.array([9.0, 0.02, 0.02, 9.0, 0.01])
    reach = within_reach(np.array([-0.03, -0.02, 1.0, 0.0, 1.0]), segments, np.array([0, 3, 5]))
    assert reach == pytest.approx([np.inf, -0.014, -0.004, np.inf, 0.008])


def test_risen_points_are_released():
    """All others are as they were: in several chunks of a parallel loop, in any state, held roots among them."""
    count, rng = 1300, np.random.default_rng(1)
    contact, probe = ContactState.none(count), SdfSample.blank(count)
    contact.state[:] = before = rng.choice(np.array([FREE, TOUCHES, NEW, INSIDE], np.int8), count)
    probe.distance[:], probe.normal[:] = rng.uniform(-3.0 * DEEP, DEEP, count), [0.0, 0.0, 1.0]
    masses = np.where(rng.random(count) < 0.2, np.inf, 1e-6)
    rise(contact, probe, np.full(count, 1e-3), np.full(count, 100.0), masses, 1 / 96)
    rises = (probe.distance < -DEEP) & np.isfinite(masses)
    assert np.array_equal(contact.state, np.where(rises, INSIDE, np.where(before == INSIDE, FREE, before)))
    assert np.array_equal(contact.discontinuous, rises != (before == INSIDE))
    assert np.array_equal(contact.c_n > 0.0, rises)
