"""Energy of particles, and a bar that meets them."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.contact.bar import roots_at, tuft
from hairpipe.graphs.experiments.studies.contact.cloud_clash import meet
from hairpipe.graphs.experiments.studies.contact.cloud_energy import energy_of, pressure_energy, work_on_links
from hairpipe.particles.contact import Planes
from hairpipe.particles.interaction import exchange, find_pairs
from hairpipe.particles.links import LinkRule, link
from hairpipe.particles.model import Moving, inverse_masses
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Air, Interaction, ParticleSettings, RestTension
from hairpipe.particles.simulate import ParticleSimulation, prepare
from hairpipe.particles.step import Forces, advance
from hairpipe.shot.shot import Frame, next_state

SETTINGS = ParticleSettings(steps=1, interaction=Interaction())


@pytest.fixture(scope="module")
def particles():
    return link(sample(tuft(), 60, "strands", 0), LinkRule(12, 0.5, 58.0, 24.0), SETTINGS.fibre.line_density)


@pytest.fixture(scope="module")
def prepared(particles):
    return prepare(particles, SETTINGS)


def scattered(particles, deep, spread, seed):
    """Points [m] so far from those at rest that links fade; those below the skin stay."""
    away = spread * particles.reach * np.random.default_rng(seed).normal(size=particles.points.shape)
    away[:deep] = 0.0
    return particles.points + away


def force_of_links(prepared, points, dt=1e-5):
    """What a step so short that nothing moves gives to particles at rest [N], (N, 3)."""
    model, count, deep = prepared.model, len(points), prepared.model.deep
    nothing, roots = np.zeros((count, 3)), np.repeat(points[None, :deep], 2, axis=0)
    planes = Planes(nothing, np.ones(count), nothing, np.zeros(count), 0.0)
    moving = Moving(points.copy(), nothing.copy(), np.zeros(len(model.links.ends)))
    springs = prepared.springs._replace(damping=0.0)
    advance(model, springs, Forces(nothing, np.zeros((count, 6))), planes, roots, dt, moving)
    return model.masses[:, None] * moving.velocities / dt


@pytest.mark.parametrize("spread", [0.05, 0.3])
def test_work_against_links_is_against_their_force(particles, prepared, spread):
    model, springs = prepared.model, prepared.springs
    points = scattered(particles, model.deep, spread, 1)
    force = force_of_links(prepared, points)
    for seed in range(5):
        way = scattered(particles, model.deep, 1e-5, seed) - particles.points
        against = -2.0 * np.sum(force * way)
        assert work_on_links(model, springs, points - way, points + way) == pytest.approx(against, rel=1e-3)


def test_links_of_constant_stiffness_have_an_energy_and_those_that_fade_none(particles, prepared):
    """Around a triangle the work of the first is nothing; that of the others is not, and changes sign with the way."""
    model, springs = prepared.model, prepared.springs
    places = [scattered(particles, model.deep, 0.3, seed) for seed in range(3)]

    def around(model, places):
        pairs = zip(places, [*places[1:], places[0]], strict=True)
        works = [work_on_links(model, springs, before, after) for before, after in pairs]
        return sum(works) / max(map(abs, works))

    constant = model._replace(reach=1e6)  # of a kernel so wide nothing fades
    assert abs(around(constant, places)) < 1e-9
    round_trip = around(model, places)
    assert abs(round_trip) > 0.01 and around(model, places[::-1]) == pytest.approx(-round_trip, rel=1e-6)


def test_force_of_pressure_is_minus_the_gradient_of_its_energy(particles, prepared):
    model, law, dt = prepared.model, prepared.law, 1e-7
    points = scattered(particles, model.deep, 0.05, 2)
    dense = law._replace(collision=0.0, friction=0.0, rest=0.5 * law.rest)

    def energy(points):
        return pressure_energy(dense, find_pairs(model.masses, points, law.h).density)

    velocities, pairs = np.zeros_like(points), find_pairs(model.masses, points, law.h)
    exchange(dense, pairs, inverse_masses(model), points, particles.directions, dt, velocities)
    force = model.masses[:, None] * velocities / dt
    assert energy(points) > 0.0
    for seed in range(5):
        way = scattered(particles, model.deep, 1e-5, seed) - particles.points
        assert energy(points - way) - energy(points + way) == pytest.approx(2.0 * np.sum(force * way), rel=1e-4)


def energies_of_fall(particles, settings, rate, seconds=0.05):
    """Energy and work against links after every step of a tuft that is kicked, over the energy of the kick."""
    prepared, settings = prepare(particles, settings), replace(settings, steps=1)
    model, driver = prepared.model, roots_at(particles.hair, 0.0, 0.0)
    frame = Frame((driver, driver), (), (), 0.0, 1.0 / rate)
    simulation = ParticleSimulation(particles, prepared, settings)
    state = next_state(simulation, None, frame)
    kick = 0.3 * np.random.default_rng(3).normal(size=state.points.shape)
    kick[: model.deep] = 0.0
    state, work = replace(state, velocities=kick), 0.0
    found = [energy_of(prepared, state, settings.gravity)]
    for _ in range(round(seconds * rate)):
        after = next_state(simulation, state, frame)
        work += work_on_links(model, prepared.springs, state.points, after.points)
        state = after
        found.append(energy_of(prepared, state, settings.gravity) + work)
    return np.array(found) / (0.5 * model.masses @ np.sum(kick**2, axis=1))


def test_in_small_steps_the_sum_falls_in_every_one_of_them(particles):
    assert np.diff(energies_of_fall(particles, SETTINGS, 960)).max() < 0.0


def test_where_nothing_takes_any_it_is_kept_but_for_a_loss_in_proportion_to_the_step(particles):
    settings = replace(SETTINGS, damping=0.0, air=Air(0.0), interaction=Interaction(collision=0.0, friction=0.0))
    losses = [np.ptp(energies_of_fall(particles, settings, rate)) for rate in (1920, 3840, 7680)]
    assert 1.5 < losses[0] / losses[1] < 2.5 and 1.5 < losses[1] / losses[2] < 2.5


CARRIED = ParticleSettings(interaction=Interaction(), sag_free=RestTension())


@pytest.fixture(scope="module")
def tuft_of_240():
    return link(sample(tuft(), 240, "strands", 0), LinkRule(12, 0.5, 58.0, 24.0), CARRIED.fibre.line_density)


def test_a_slow_bar_goes_through_no_hair_and_has_none_inside(tuft_of_240):
    worst = meet(tuft_of_240, CARRIED, 0.5, 120, 0.2)
    assert worst.finite and worst.steps == 24 and not worst.through.any()
    assert worst.deepest < 1e-4 and worst.stretch > 0.0


def test_a_bar_that_goes_ten_times_its_radius_in_a_frame_goes_through(tuft_of_240):
    worst = meet(tuft_of_240, CARRIED, 8.0, 24, 0.25)
    assert worst.finite and worst.through.any()
