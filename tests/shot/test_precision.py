"""Hair in single precision: as good as in double where it is chosen, and not chosen where it is not."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.laws.settings import Collisions, Rest, Share, Stiction
from hairpipe.shot.simulate import choose_precision, start
from hairpipe.strands.hair_model import build_hair, build_models
from hairpipe.strands.material import Material
from hairpipe.strands.network import NETWORK, highest_frequency
from hairpipe.strands.registry import strand_models

SECONDS = 0.25


@pytest.fixture
def swing(scene, straight):
    """A strand that falls from a slant, of so many segments."""

    def make(precision, segments, step):
        shot = scene([straight(0.2, segments, (1.0, -1.0, 0.0))], step=step)
        shot.hair = choose(precision, shot)
        shot.state = start(shot.hair, shot.body, shot.scene)
        return shot

    return make


def choose(asked, shot, *, bodies=False, first=False):
    models = build_models(shot.hair.groom, Material(), "network")
    return choose_precision(asked, models, shot.scene, bodies=bodies, first=first)


def of(hair):
    return {"float64": "double", "float32": "single"}[hair.layout.dtype.name]


def test_it_moves_hair_as_double_does(swing):
    double, single = (swing(precision, 10, 1 / 480).run(SECONDS) for precision in ("double", "single"))
    assert single.state.velocities.dtype == single.state.tensions.dtype == np.float32
    assert single.state.positions.dtype == np.float64  # of the world
    assert np.abs(double.points - swing("double", 10, 1 / 480).points).max() > 0.05
    assert np.abs(single.points - double.points).max() < 2e-4


def test_it_is_chosen_up_to_a_length_of_steps(swing):
    longest = NETWORK.single_limit / highest_frequency(swing("double", 50, 1 / 240).hair.model)
    assert of(swing("automatic", 50, 0.99 * longest).hair) == "single"
    assert of(swing("automatic", 50, 1.01 * longest).hair) == "double"


@pytest.mark.parametrize(("name", "segments"), [("network", 8), ("chain", 25), ("rod", 25)])
def test_rounding_is_less_than_the_error_of_a_step_up_to_the_limit_of_every_model(scene, straight, name, segments):
    """Of hair as stiff as the limit allows, in ways that are no axis."""
    step, ways = 1 / 240, np.random.default_rng(1).normal(size=(8, 3)) * [1.0, 0.3, 1.0]
    groom = scene([straight(0.2, segments, way) for way in ways]).hair.groom
    limit = strand_models()[name].single_limit
    softening = Material().softening * (step * build_models(groom, Material(), name).highest_frequency / limit) ** 2
    assert softening > 1.0
    models = build_models(groom, Material(softening=1.001 * softening), name)

    def fallen(asked, step):
        shot = scene([straight(0.2, segments, way) for way in ways], step=step, model=name)
        shot.hair = choose_precision(asked, models, shot.scene, bodies=False)
        shot.state = start(shot.hair, shot.body, shot.scene)
        return shot.run(SECONDS).points, of(shot.hair)

    asked = ("automatic", step), ("double", step), ("double", step / 4)
    (single, chosen), (double, _), (fine, _) = (fallen(*each) for each in asked)
    assert chosen == "single"
    off, error = (np.sqrt(np.mean((points - double) ** 2)) for points in (single, fine))
    assert 0.0 < off < error


@pytest.mark.parametrize(
    "settings", [{"stiction": Stiction()}, {"collisions": Collisions()}, {"rest": Rest(balanced=Share(1.0))}]
)
def test_hair_that_touches_hair_or_stands_stays_in_double(swing, settings):
    shot = swing("automatic", 10, 1 / 480)
    assert of(shot.hair) == "single"
    shot.scene = replace(shot.scene, **settings)
    assert of(choose("automatic", shot)) == "double"


def test_hair_that_may_touch_a_body_stays_in_double(swing):
    shot = swing("automatic", 10, 1 / 480)
    assert of(choose("automatic", shot, bodies=True)) == "double"


def test_requested_precision_is_used(swing):
    assert of(swing("double", 10, 1 / 480).hair) == "double"
    assert of(choose("single", swing("double", 50, 1 / 240), bodies=True)) == "single"


def test_the_choice_is_stated_once(swing):
    shot = swing("double", 10, 1 / 480)
    steps = round(highest_frequency(shot.hair.model) / 480)
    with pytest.warns(UserWarning, match=f"in single precision: .* {steps} explicit steps per step, of 300"):
        choose("automatic", shot, first=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        choose("automatic", shot)
        choose("automatic", swing("double", 50, 1 / 240), first=True)
        choose("single", shot, first=True)
        choose("double", shot, first=True)


def test_unsafe_steps_warn_with_the_longest_safe_one(swing):
    shot = swing("double", 50, 1 / 240)
    longest = NETWORK.single_limit / highest_frequency(shot.hair.model)
    with pytest.warns(UserWarning, match=f"insufficient for steps beyond {longest:.2g} s"):
        choose("single", shot, first=True)
    with pytest.warns(UserWarning, match="insufficient for hair that touches a body"):
        choose("single", shot, bodies=True, first=True)


def test_the_limit_is_a_number_of_explicit_steps_whatever_hair_is_made_of(swing):
    coarse, fine = (highest_frequency(swing("double", n, 1 / 240).hair.model) for n in (10, 20))
    assert 1.8 < fine / coarse < 2.2
    groom = swing("double", 10, 1 / 240).hair.groom
    light, heavy = (
        highest_frequency(build_hair(groom, Material(density=d), "network").model) for d in (1000.0, 4000.0)
    )
    np.testing.assert_allclose(light / heavy, 2.0, rtol=1e-9)


def test_it_is_refused_for_a_start_without_sag(swing):
    shot = swing("double", 6, 1 / 240)
    shot.scene = replace(shot.scene, rest=Rest(balanced=Share(1.0)))
    with pytest.raises(BadInput, match="impossible in single precision"):
        choose("single", shot)
    assert of(choose("automatic", shot)) == "double"
