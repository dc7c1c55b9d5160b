"""Hair at rest under gravity, found without the way there, against rod theory and against the simulation."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.laws.settings import Construction, SagFree
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.solve.sag_free import assemble
from hairpipe.solve.settle import STILL, settle, settle_groom
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

GRAVITY = np.array([0.0, -9.81, 0.0])


@pytest.fixture
def settled(scene):
    """Hair of these strands, and where it settles."""

    def run(strands, **settings):
        hair = scene(strands, **settings).hair
        everyone = np.ones(hair.layout.strands.shape, bool)
        return hair, settle(hair.model, hair.layout, hair.groom.ids, hair.rest, GRAVITY, everyone)

    return run


def curl(length=0.15):
    """A curl that hangs."""
    return wound(Helix(radius=0.003, pitch=0.012), length, 75) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.mark.parametrize("gamma", [0.3, 3.0, 30.0, 1000.0])
@pytest.mark.parametrize("model", ["network", "chain"])
def test_it_finds_the_elastica(settled, straight, gamma, model):
    material = Material()
    length = (gamma * material.bending / (material.line_density * 9.81)) ** (1 / 3)
    hair, found = settled([straight(length, 50, [1, 0, 0])], material=material, model=model)
    axis = hair.layout.axis(found.positions)
    tip = (axis[-1] - axis[0]) / length
    np.testing.assert_allclose(tip, [*bend_elastica(gamma).tip, 0.0], atol=0.01)


def test_no_force_is_left(settled, straight):
    hair, found = settled([straight(0.3, 50, [1, 0, 0]), straight(0.1, 50, [1, 1, 0]), straight(0.3, 50, [0.05, 1, 0])])
    forces = assemble(hair.model, 0, found.positions, found.tensions, 0)[1]
    left = forces + hair.model.mass[:, None] * GRAVITY[:, None]
    mass = hair.model.mass[3:].sum(0)
    assert np.all(np.abs(left[3:]) <= 1.01 * STILL * mass)
    assert np.all(found.left <= STILL)


@pytest.mark.parametrize("model", ["network", "chain"])
def test_it_is_where_the_simulation_comes_to_rest(settled, scene, straight, model):
    strands = [straight(0.1, 25, [1, 0, 0]), straight(0.3, 25, [1, -0.3, 0])]
    hair, found = settled(strands, model=model)
    axis = scene(strands, drag=15.0, model=model).run(6.0).axis
    np.testing.assert_allclose(hair.layout.axis(found.positions), axis, atol=1e-4)


def test_the_settled_groom_keeps_its_shape_when_it_is_simulated_sag_free(scene, straight):
    s = scene([straight(0.1, 50, [1, 0, 0]), straight(0.3, 50, [1, 0, 0]), curl()])
    groom = settle_groom(s.hair.groom, Material(), Construction(), 9.81, "network")
    np.testing.assert_array_equal(groom.points[groom.offsets[:-1]], s.hair.groom.points[groom.offsets[:-1]])
    hair, sag_free = build_hair(groom, Material(), "network"), replace(s.scene, sag_free=SagFree())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        state = start(hair, s.body, sag_free)
    for _ in range(48):
        state = advance_frame(hair, state, (s.body, s.body), (), 1 / 24, sag_free)
    moved = hair.layout.axis(state.positions) - groom.points
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) < 1e-6


def test_those_that_are_not_asked_stay(settled, straight):
    hair, _ = settled([straight(0.1, 25, [1, 0, 0]), straight(0.2, 25, [1, 0, 0])])
    who = hair.layout.strands == 1
    found = settle(hair.model, hair.layout, hair.groom.ids, hair.rest, GRAVITY, who)
    axis = hair.layout.axis(found.positions)
    np.testing.assert_array_equal(axis[:26], hair.groom.points[:26])
    assert np.linalg.norm(axis[-1] - hair.groom.points[-1]) > 0.1


def test_moving_strands_are_named(settled, straight):
    hair, found = settled([straight(0.1, 25, [1, 0.1, 0]), straight(0.1, 25, [1, 0, 0])])
    lost, everyone = hair.rest.copy(), np.ones(hair.layout.strands.shape, bool)
    lost[20, :, 1:] = np.nan
    with pytest.warns(UserWarning, match="1 of 2 strands have not come to rest: strands 1"):
        again = settle(hair.model, hair.layout, hair.groom.ids, lost, GRAVITY, everyone)
    np.testing.assert_array_equal(again.positions[..., 0], found.positions[..., 0])


def test_it_depends_neither_on_threads_nor_on_other_strands(settled, straight, same_on_threads):
    strands = [straight(0.02 * (i + 1), 25, [1, 0.1 * i, 0]) for i in range(12)]

    def points_of(strands):
        hair, found = settled(strands)
        return hair.layout.axis(found.positions)

    many = same_on_threads(lambda: points_of(strands))
    for i in (0, 5, 11):
        np.testing.assert_array_equal(points_of([strands[i]]), many[26 * i : 26 * (i + 1)])
