"""Hair that comes to rest on a body, on other hair, and in a pile."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.body.shapes import build_box
from hairpipe.geometry.proximity import near_pairs
from hairpipe.graphs.experiments.studies.contact.rub import ends_at, lay_crossed
from hairpipe.laws.settings import Air, BodyContact, Collisions, Drag, Thickness
from hairpipe.levelset.bake import bake
from hairpipe.nodes.make_strands import make_strands
from hairpipe.shot.build import bodies_of
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

from ..strand_scenes import groom_of

FPS, FRAMES = 24.0, 72
BOX = bake(build_box((0.03, 0.03, 0.05), (0.05, -0.025, 0.0)), 0.004, 4.0)


@pytest.mark.parametrize("model", ["network", "rod"])
def test_hair_at_rest_reports_the_velocity_of_its_motion(model):
    scene = Scene(contact=BodyContact(thickness=0.5e-3), strain=None)
    hair = build_hair(groom_of([np.linspace(0.0, 0.1, 13)[:, None] * [1.0, 0.0, 0.0]]), Material(), model)
    bodies = bodies_of([(BOX, BOX)], [], scene.contact, 1.0 / FPS)
    state = start(hair, None, scene)
    frames = []
    for frame in range(FRAMES):
        state = advance_frame(hair, state, (None, None), bodies, 1.0 / FPS, scene, frame / FPS)
        frames.append(strands_of(hair, state))
    before, now = frames[-2:]
    assert np.abs(now.velocities - FPS * (now.points - before.points)).max() < 1e-5
    assert np.abs(now.points - before.points).max() < 1e-6
    assert now.points[-1, 1] < -0.01  # It hangs over the edge.


@pytest.mark.kernels
def test_soft_heavy_hair_comes_to_rest_on_hair():
    """Its weight strains it by less than the strain limit, which may not draw it through the hair below."""
    collisions = Collisions(Thickness(5e-4))
    scene = Scene(collisions=collisions)
    soft = Material(young=2e6, density=1e4, softening=1.0)
    hair = build_hair(lay_crossed(1.5e-3, 25, 0.0, 0.015), soft, "rod")
    still = CubicHermiteSpline([0.0, 10.0], np.zeros((2, 3)), np.zeros((2, 3)))
    ends = ends_at(still, 0.0)
    state = start(hair, ends, scene)
    for frame in range(36):
        state = advance_frame(hair, state, (ends, ends), (), 1.0 / FPS, scene, frame / FPS)
    tip = hair.layout.axis(state.positions)[-1]
    assert tip[1] > -0.02  # Half of it hangs down from the hair below; without that it would hang from its root.


LAW = Collisions()


@pytest.fixture
def pile(scene, triangle):
    """Give four strands side by side and twelve across them, each 0.4 mm above the one before."""

    def make(step):
        base, rng = triangle().points.mean(0), np.random.default_rng(0)
        strands = [base + [0, 0, 0.004 * k] + np.linspace(0, 0.03, 11)[:, None] * [1, 0, 0] for k in range(4)]
        for k in range(12):
            aside = 0.004 + 0.004 * (k % 5) + rng.uniform(-1e-4, 1e-4)
            place = base + np.array([aside, 0.0006 + 0.0004 * k, -0.02])
            strands.append(place + np.linspace(0, 0.05, 17)[:, None] * [0, 0, 1])
        shot = scene(strands, step=step, drag=2.0)
        shot.scene = replace(shot.scene, collisions=LAW)
        return shot

    return make


def heights_over(shot):
    """How far strands are above the others where they cross, seen from above [m]."""
    x, offsets = shot.axis, shot.hair.layout.offsets
    under, over = (
        np.concatenate([np.arange(offsets[s], offsets[s + 1] - 1) for s in r]) for r in (range(4), range(4, 16))
    )
    i, j = (part.ravel() for part in np.meshgrid(under, over, indexing="ij"))
    a, c, r = x[i + 1] - x[i], x[j + 1] - x[j], x[j] - x[i]
    area = a[:, 0] * c[:, 2] - a[:, 2] * c[:, 0]
    s, t = (r[:, 0] * c[:, 2] - r[:, 2] * c[:, 0]) / area, (r[:, 0] * a[:, 2] - r[:, 2] * a[:, 0]) / area
    cross = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return (r + t[:, None] * c - s[:, None] * a)[cross, 1]


def test_crossing_hairs_rest_with_the_coupled_solver_and_not_with_the_published_one(scene):
    """A hair of 45 mm falls across one of 30 mm without friction: what `warn_of_sweep` warns of."""
    along, end = np.linspace(0.0, 1.0, 25)[:, None], {}
    over, under = along * [0.045, 0.0, 0.0], [0.03, -2e-3, -0.02] + along * [0.0, 0.0, 0.03]
    for solver in ("coupled", "sweep"):
        shot = scene([over, under], step=1 / 48, drag=0.5)
        shot.scene = replace(shot.scene, collisions=Collisions(Thickness(1e-3), friction=0.0, solver=solver))
        end[solver] = np.abs(shot.run(2.0).state.velocities).max()
    assert end["coupled"] < 0.01 and end["sweep"] > 5.0 * end["coupled"]


@pytest.mark.parametrize("step", [1 / 60, 1 / 240])
def test_pile_comes_to_rest(pile, step):
    shot, fastest = pile(step), []
    for _ in range(16):
        shot.run(1 / 24)
        fastest.append(np.abs(shot.state.velocities).max())
    assert max(fastest) < 1.0 and max(fastest[-3:]) < 0.3
    heights = heights_over(shot)
    assert len(heights) > 30 and (heights > 0.5 * LAW.thickness.value).all()
    near = near_pairs(shot.axis, shot.hair.layout.offsets, LAW.thickness.value)
    assert len(near.distances) > 5 and near.distances.min() > 0.5 * LAW.thickness.value


def test_a_strand_that_has_coiled_up_around_itself_comes_to_rest():
    """Contacts that end and begin under load would keep it at several millimetres a second, for ever."""
    groom = make_strands(length=0.3, segments=100, arch=0.02)
    scene = Scene(strain=None, gravity=0.0, air=Air(Drag(20.0)), collisions=Collisions(Thickness(4e-3)))
    nearer, turn = ((0.0, 0.0, 0.0), (-0.15, 0.0, 0.0), (-0.15, 0.0, 0.0)), (0.0, 0.0, 1620.0)
    hands = Track((0.0, 1.0, 4.0), nearer, turn)
    ends = [drive(groom, min(frame / FPS, 4.0), Track(), None, hands, None) for frame in range(217)]
    hair = build_hair(groom, Material(), "rod")
    state, speeds = start(hair, ends[0], scene), []
    for frame, driver in enumerate(pairwise(ends)):
        state = advance_frame(hair, state, driver, (), 1.0 / FPS, scene, frame / FPS)
        speeds.append(np.linalg.norm(hair.layout.axis(state.velocities), axis=1).max())
    assert max(speeds) > 0.1 and max(speeds[-12:]) < 5e-4
    assert near_pairs(hair.layout.axis(state.positions), hair.layout.offsets, 4.5e-3).distances.min() > 2.5e-3


def test_director_past_a_free_tip_of_a_rod_moves_with_the_tip():
    """It has no equation: a speed of its own would stay for ever, and would bound the steps of all hair."""
    scene = Scene()
    hair = build_hair(groom_of([np.linspace(0.0, 0.1, 11)[:, None] * [1.0, 0.0, 0.0]]), Material(), "rod")
    state = start(hair, None, scene)
    past = hair.model.first[1:] - 1
    state.velocities[past] += 10.0
    state.positions[past] += 1.0
    state = advance_frame(hair, state, (None, None), (), 1.0 / FPS, scene, 0.0)
    np.testing.assert_array_equal(state.velocities[past], state.velocities[past - 1])
    ahead = state.positions[past] - state.positions[past - 1]
    np.testing.assert_allclose(np.linalg.norm(ahead, axis=1), 0.01, rtol=0.02)
