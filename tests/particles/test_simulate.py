"""A curtain of particles hangs, splits and merges, keeps out of bodies, and comes to rest."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import jv

from hairpipe.errors import BadInput
from hairpipe.laws.settings import Wind
from hairpipe.particles.interaction import find_pairs
from hairpipe.particles.links import link
from hairpipe.particles.model import LOAD, build_model
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Interaction, ParticleContact, RestTension
from hairpipe.particles.simulate import ParticleSimulation, cloud_of, laws_of, start
from hairpipe.shot.shot import Frame, next_state
from hairpipe.values.hair import ParticleState

from .conftest import RULE, copy_of, groom_of, make_ball, plate

FRAME = 1 / 24


def moved_by(shot):
    return np.linalg.norm(shot.state.points - shot.particles.points, axis=1)


def test_hair_sags_as_asked_and_not_at_all_with_links_that_carry_it(shot):
    """The bar that it is taken for: stretched by `sag` at the root, half of that on the mean, which lowers its tip."""
    hung, carried = (shot(interaction=Interaction(), sag_free=s).run(72) for s in (None, RestTension()))
    lowest = hung.particles.arcs > 0.18
    assert moved_by(hung)[lowest].mean() == pytest.approx(0.05 * 0.2, rel=0.6)
    assert moved_by(carried).mean() < 0.1 * moved_by(hung).mean()
    for at_rest in (hung, carried):
        assert at_rest.pace < 1e-3 and at_rest.out < 0.02


def test_stiff_pressure_neither_draws_particles_together_nor_makes_them_tremble(shot):
    pressed = shot(interaction=Interaction(pressure=100.0)).run(48)
    assert pressed.crowding >= 0.9
    assert pressed.pace < 1e-3


def test_sparse_hair_may_be_compressed_to_the_largest_density():
    """A fan of hair: where its tips come as close as its roots are, nothing presses; at rest nothing does anywhere."""
    roots = np.random.default_rng(3).uniform(-0.02, 0.02, (300, 3)) * (1.0, 0.0, 1.0)
    fan = [root + np.linspace(0.0, 0.2, 21)[:, None] * (8.0 * root[0], -1.0, 8.0 * root[2]) for root in roots]
    particles = link(sample(groom_of(fan), 500, "strands", 0), RULE, 1e-5)
    model = build_model(particles)
    own = find_pairs(model.masses, particles.points, model.range).density
    law, printed = laws_of(Interaction(), (), model, particles.points)
    dense = np.quantile(own[model.deep :], 0.99)
    assert printed is None and (law.rest >= own).all() and own.min() < 0.3 * dense
    assert np.unique(law.rest[own < dense]) == pytest.approx([dense])


def test_hair_that_is_pulled_apart_splits_and_merges(shot):
    torn = shot(interaction=Interaction())
    rest, links = torn.particles.points, torn.particles.links
    side = np.where(rest[:, 0] > 0.0, 1.0, -1.0)
    free, low = torn.particles.arcs >= 0.0, torn.particles.arcs > 0.1
    across = side[links[:, 0]] != side[links[:, 1]]

    def gap():
        x = torn.state.points[:, 0]
        return np.quantile(x[low & (side > 0)], 0.05) - np.quantile(x[low & (side < 0)], 0.95)

    def open_links():
        ends = torn.state.points[links[across]]
        return np.mean(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 2.0 * torn.particles.reach)

    began = gap()
    torn.run(24, kick=lambda frame: np.outer(side * free, (15.0 * FRAME, 0.0, 0.0)))
    assert gap() > 4.0 * began and open_links() > 0.5
    torn.run(72)
    assert open_links() < 0.02 and gap() < 2.0 * began
    assert np.mean(side[low] * torn.state.points[low, 0] < -0.01) < 0.01


def test_shaken_hair_is_torn_nowhere_for_long_and_comes_to_rest(shot):
    def shaken(frame):
        seconds = (frame + 1) * FRAME
        return plate((0.08 * np.sin(2.0 * np.pi * 2.0 * seconds), 0.0, 0.0))

    hair = shot(interaction=Interaction()).run(24, shaken)
    swung = np.abs(hair.state.velocities[:, 0]).max()
    hair.run(72)
    assert swung > 0.5 and hair.pace < 5e-3 and hair.out < 0.05
    assert hair.state.points[:, 1].min() > hair.particles.points[:, 1].min() - 0.05


def test_hair_of_a_head_thrown_at_2500_degrees_a_second_stays_finite_and_comes_back(shot):
    rate = np.deg2rad(2500.0)

    def thrown(frame):
        angle, spin = rate * FRAME * min(frame + 1, 6), rate if frame < 5 else 0.0
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        body = plate(turn=turn)
        return replace(body, velocities=spin * np.cross([0.0, 1.0, 0.0], body.points))

    hair = shot(interaction=Interaction()).run(6, thrown)
    assert np.isfinite(hair.state.points).all()
    fastest = np.linalg.norm(hair.state.velocities, axis=1).max()
    hair.run(96, lambda frame: thrown(6))
    assert fastest > 3.0 and hair.pace < 0.02 and hair.out < 0.05


@pytest.mark.parametrize("steps", [1, 2])
def test_no_particle_is_in_a_ball_that_goes_through_the_curtain(shot, steps):
    hair, velocity = shot(interaction=Interaction(), steps=steps), np.array([0.0, 0.0, 1.5])

    def at(frame):
        return (make_ball(np.array([0.0, -0.1, -0.12 + frame * FRAME * 1.5]), velocity),)

    pushed = 0.0
    for frame in range(6):
        hair.run(1, bodies=at(frame))
        centre = np.array([0.0, -0.1, -0.12 + (frame + 1) * FRAME * 1.5])
        assert np.linalg.norm(hair.state.points - centre, axis=1).min() > 0.04 - 1e-12
        pushed = max(pushed, hair.state.velocities[:, 2].max())
    assert pushed > 1.0


def test_bytes_are_the_same_again_with_other_threads_and_from_any_frame_on(shot, threads):
    def swung(count, frames=6):
        threads(count)
        hair = shot(interaction=Interaction(), steps=2)
        return hair.run(frames, kick=lambda frame: np.array([0.5, 0.0, 0.2]))

    one, two = swung(1), swung(2)
    assert copy_of(one.state) == copy_of(two.state)
    half = swung(2, 3)
    assert copy_of(half.run(3, kick=lambda frame: np.array([0.5, 0.0, 0.2])).state) == copy_of(one.state)


def test_over_a_cut_shape_and_motion_against_the_roots_are_kept(shot):
    hair = shot().run(4, kick=lambda frame: np.array([0.5, 0.0, 0.2]))
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    there = plate((3.0, 2.0, -4.0), turn)
    carried = hair.simulation.move_over_cut(hair.state, (plate(), there))
    assert carried.points == pytest.approx(hair.state.points @ turn.T + (3.0, 2.0, -4.0), abs=1e-12)
    assert carried.velocities == pytest.approx(hair.state.velocities @ turn.T, abs=1e-9)
    assert carried.directions == pytest.approx(hair.state.directions @ turn.T, abs=1e-12)
    # Gravity turns about itself, so what follows is the same, there.
    straight = hair.run(6).state.points @ turn.T + (3.0, 2.0, -4.0)
    hair.state, hair.body = carried, there
    assert hair.run(6).state.points == pytest.approx(straight, abs=1e-5)


def test_particles_start_with_their_roots_as_they_move(shot):
    hair = shot()
    moving = plate((1.0, 0.0, 0.0), velocities=np.tile([0.0, 2.0, 0.0], (3, 1)))
    begun = start(hair.simulation, Frame((None, moving), (), (), 0.0, FRAME), ())
    assert begun.points == pytest.approx(hair.particles.points + np.array([1.0, 0.0, 0.0]), abs=1e-12)
    assert begun.velocities == pytest.approx(np.tile([0.0, 2.0, 0.0], (len(begun.points), 1)), abs=1e-9)
    assert cloud_of(begun).velocities.dtype == np.float32


def test_hair_without_a_body_to_touch_is_named(shot):
    hair = shot()
    settings = replace(hair.settings, contact=ParticleContact(friction=0.9))
    for driver, given in ((plate(), hair.settings), (None, settings)):
        simulation = ParticleSimulation(hair.particles, hair.prepared, given)
        with pytest.warns(UserWarning, match="without in.surface and in.parts: hair passes through bodies"):
            next_state(simulation, None, Frame((driver, driver), (), (), 0.0, FRAME))


def test_hair_that_is_not_finite_is_named_and_a_body_around_all_of_it_refused(shot):
    hair = shot()
    broken = hair.state.velocities.copy()
    lost = hair.prepared.model.deep + 3
    broken[lost] = np.nan
    state = ParticleState(hair.state.points, broken, hair.state.directions, hair.state.tensions)
    given = Frame((hair.body, hair.body), (), (), 0.0, FRAME)
    with pytest.raises(ArithmeticError, match=f"strands {hair.particles.hair.ids[hair.particles.strands[lost]]}"):
        next_state(hair.simulation, state, given)
    around = make_ball(np.array([0.0, -0.1, 0.0]), np.zeros(3), 2.0)
    with pytest.raises(BadInput, match="all particles are inside the body"):
        start(hair.simulation, given, (around,))


def farthest(hair):
    """Distance of particles from their roots over that at rest along the hair, which is straight."""
    deep, particles = hair.prepared.model.deep, hair.particles
    roots = particles.hair.points[particles.hair.offsets[:-1]][particles.strands[deep:]]
    return np.linalg.norm(hair.state.points[deep:] - roots, axis=1)


def test_wind_throws_no_particle_farther_than_hair_stretches(shot):
    hair = shot(wind=Wind((0.0, 0.0, -30.0)))
    with pytest.warns(UserWarning, match=r"are too far from their roots at frame 1, the farthest .* m, over .* m, on"):
        hair.run(4)
    assert farthest(hair).max() <= (LENGTH + hair.particles.reach) * (1.0 + LOAD * hair.settings.sag / 2.0) + 1e-9
    assert hair.pace < 40.0


def test_hair_that_hangs_and_swings_is_within_reach(shot):
    hair = shot()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hair.run(6, kick=lambda frame: np.array([2.0, 0.0, 0.0]) * (frame == 0))
    assert farthest(hair).max() > LENGTH


def test_wind_that_tears_hair_from_its_roots_diverges_with_numbers(shot):
    with pytest.raises(ArithmeticError, match=r"^diverged: \d+ of \d+ particles .* the farthest .*e\+\d+ m, over"):
        shot(wind=Wind((0.0, 0.0, 1e8))).run(2)


def test_wind_that_no_solve_can_hold_diverges_with_numbers(shot):
    """It left hair where it was, at speed 0."""
    with pytest.raises(ArithmeticError, match=r"^diverged: the force of air on a particle is .*e\+\d\d N"):
        shot(wind=Wind((0.0, 0.0, 1e30))).run(1)


LENGTH, LOWER, DRAG, GRAVITY = 0.2, 0.15, 3.0, 9.81
WAY = np.array([0.0, 0.0, 0.01])
"""Across the curtain, where it is thin: along it, hair that acts on hair stiffens it."""


def of_chain(rate):
    """Lag of the lower quarter [frames], and its swing over that of the rail; linear theory, z up from the tip:

    J0(2 k sqrt(z)) / J0(2 k sqrt(L)), g k^2 = w (w - i drag).
    """
    k, heights = np.sqrt(rate * (rate - 1j * DRAG) / GRAVITY), np.linspace(0.0, LENGTH - LOWER, 50)
    response = np.mean(jv(0, 2.0 * k * np.sqrt(heights))) / jv(0, 2.0 * k * np.sqrt(LENGTH))
    return -np.angle(response) / rate / FRAME, np.abs(response)


def swung(shot, rate, sag):
    """The same of the curtain, after three seconds."""

    def rail(frame):
        seconds = (frame + 1) * FRAME
        velocity = WAY * rate * np.cos(rate * seconds)
        return plate(WAY * np.sin(rate * seconds), velocities=np.tile(velocity, (3, 1)))

    hair, places = shot(interaction=Interaction(), sag=sag), []
    for frame in range(144):
        hair.run(1, lambda _, frame=frame: rail(frame))
        places.append((hair.state.points - hair.particles.points)[hair.particles.arcs > LOWER, 2].mean())
    phases = rate * FRAME * np.arange(73, 145)
    waves = np.stack([np.sin(phases), np.cos(phases), np.ones(72)], axis=1)
    sine, cosine, _ = np.linalg.lstsq(waves, np.array(places[72:]), rcond=None)[0]
    response = (sine + 1j * cosine) / WAY[2]
    return -np.angle(response) / rate / FRAME, np.abs(response)


@pytest.mark.parametrize("hertz", [1.0, 2.0])
def test_it_lags_and_swings_as_a_chain_does_and_hardly_at_ten_times_the_modulus(shot, hertz):
    rate = 2.0 * np.pi * hertz
    (lag, swing), (chain_lag, chain_swing) = swung(shot, rate, 0.1), of_chain(rate)
    assert abs(lag - chain_lag) < 1.0 and swing == pytest.approx(chain_swing, rel=0.2)
    assert swung(shot, rate, 0.01)[0] < 1.0
