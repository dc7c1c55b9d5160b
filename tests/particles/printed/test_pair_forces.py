"""Pressure (16) and friction (18) as printed: they attract, and add energy, where ours do neither."""

import numpy as np
import pytest

from hairpipe.particles.interaction import PrintedLaw, find_pairs, push_pairs
from hairpipe.particles.model import kernel
from hairpipe.particles.settings import Interaction

H, MASS, DT = 0.02, 1.5e-5, 1 / 24


def pushed(points, velocities, pressure=0.0, friction=0.0, rest=0.0, dt=DT):
    """Velocities after dt of particles whose hair goes along z."""
    pairs = find_pairs(np.full(len(points), MASS), points, H)
    after, directions = velocities.copy(), np.tile([0.0, 0.0, 1.0], (len(points), 1))
    law = PrintedLaw(pressure, friction, rest, H, MASS)
    push_pairs(law, pairs, np.full(len(points), 1.0 / MASS), points, directions, dt, after)
    return after


@pytest.mark.parametrize("law", [{"pressure": 4.0, "rest": 30.0}, {"friction": 50.0}])
def test_momentum_is_kept(law):
    rng = np.random.default_rng(0)
    points, velocities = rng.uniform(0.0, 0.08, (100, 3)), rng.normal(size=(100, 3))
    after = pushed(points, velocities, **law)
    assert np.abs(after - velocities).max() > 0.1
    assert np.abs((after - velocities).sum(axis=0)).max() < 1e-14 * np.abs(velocities).sum()


def test_pressure_is_that_of_the_paper_and_attracts_where_hair_is_thin():
    """Of a pair: by the derivative of the kernel, in differences."""
    points, still, k, rest = np.array([[0.0, 0.0, 0.0], [0.017, 0.0, 0.0]]), np.zeros((2, 3)), 2.0, 10.0
    density = MASS * (kernel(np.zeros(1), H)[0] + kernel(np.array([0.017]), H)[0])
    steep = np.diff(kernel(np.array([0.017 - 1e-7, 0.017 + 1e-7]), H))[0] / 2e-7
    expected = -2.0 * MASS * k * (density - rest) / density**2 * steep * DT
    speed = pushed(points, still, pressure=k, rest=rest)[1, 0]
    assert density < rest and speed == pytest.approx(expected, rel=1e-6) and speed < 0.0


def test_friction_adds_energy_where_the_step_is_too_long_for_its_rate():
    """In one place d_f W dt is rate dt / 4 m: relative speed goes as 1 - 2 rate dt, and grows where that is over 2."""
    points, velocities = np.zeros((2, 3)), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for rate in (1.0, 20.0, 50.0, 200.0):
        after = pushed(points, velocities, friction=rate)
        assert after[1, 2] - after[0, 2] == pytest.approx(1.0 - 2.0 * rate * DT)


def test_hair_at_rest_clumps_by_it_and_explodes(shot):
    stiff = Interaction(pressure=4.0)
    ours, printed = shot(interaction=stiff).run(48), shot(interaction=stiff, printed=("pressure",)).run(48)
    assert ours.crowding > 0.85 and ours.pace < 1e-3
    assert printed.crowding < 0.5 and printed.pace > 0.1


def test_hair_at_rest_explodes_by_friction(shot):
    sticky = Interaction(friction=200.0)
    ours, printed = shot(interaction=sticky).run(48), shot(interaction=sticky, printed=("friction",)).run(48)
    assert ours.pace < 1e-3 and printed.pace > 1.0
