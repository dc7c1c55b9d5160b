"""Hair in single precision: as good as in double where it is allowed, and refused where it is not."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.sim.advance import start
from hairpipe.sim.control import highest_frequency
from hairpipe.sim.hair import make_hair
from hairpipe.sim.material import Material
from hairpipe.sim.precision import MOST
from hairpipe.sim.scene import Collisions, SagFree, Stiction

SECONDS = 0.25


@pytest.fixture
def swing(scene, straight):
    """A few strands that lie close and fall from a slant, of so many segments."""

    def make(precision, segments, step, **settings):
        strands = [straight(0.2, segments, (1.0, -1.0, 0.0)) + np.array([0.0, 0.0, 4e-4 * i]) for i in range(3)]
        shot = scene(strands, step=step)
        shot.hair = make_hair(shot.hair.groom, Material(), precision=precision)
        shot.scene = shot.scene.__class__(**{**vars(shot.scene), **settings})
        shot.state = start(shot.hair, shot.body, shot.scene)
        return shot

    return make


TOUCHING = {"stiction": Stiction(), "collisions": Collisions()}


def test_it_moves_hair_as_double_does(swing):
    double, single = (swing(precision, 10, 1 / 480).run(SECONDS) for precision in ("double", "single"))
    assert single.state.positions.dtype == single.state.tensions.dtype == np.float32
    assert np.abs(double.points - swing("double", 10, 1 / 480).points).max() > 0.05
    assert np.abs(single.points - double.points).max() < 2e-4


def test_hair_that_touches_stays_with_its_neighbours(swing):
    """It differs by more than lone hair: where hair touches, rounding moves it about as far as half the step does."""
    double, single = (swing(precision, 10, 1 / 480, **TOUCHING).run(SECONDS) for precision in ("double", "single"))
    assert len(double.state.stuck) > 10
    assert np.abs(single.points - double.points).max() < TOUCHING["stiction"].release


def test_steps_that_are_too_long_for_it_are_refused_with_the_longest_that_is_not(swing):
    with pytest.raises(BadInput, match="single precision is too little") as refused:
        swing("single", 50, 1 / 240)
    longest = MOST / highest_frequency(swing("double", 50, 1 / 240).hair.model)
    assert f"{longest:.2g} s" in refused.value.right
    swing("single", 50, 0.9 * longest)


def test_the_limit_is_a_number_of_explicit_steps_whatever_hair_is_made_of(swing):
    coarse, fine = (highest_frequency(swing("double", n, 1 / 240).hair.model) for n in (10, 20))
    assert 1.8 < fine / coarse < 2.2
    groom = swing("double", 10, 1 / 240).hair.groom
    light, heavy = (highest_frequency(make_hair(groom, Material(density=d)).model) for d in (1000.0, 4000.0))
    np.testing.assert_allclose(light / heavy, 2.0, rtol=1e-9)


def test_a_start_without_sag_is_refused(swing):
    with pytest.raises(BadInput, match="double precision"):
        swing("single", 10, 1 / 480, sag_free=SagFree())
