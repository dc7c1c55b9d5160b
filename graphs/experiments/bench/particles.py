"""Cost of hair of particles: a frame of a shaking head, its parts, and how it grows with their number."""

import gc
import time
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import TypeVar

import numba
import numpy as np
from numba import njit

from hairpipe.body.bust import build_bust
from hairpipe.geometry.vec3 import length, minus, row, scaled
from hairpipe.graphs.experiments.bench.head import FPS, HALF_WIDTH, LENGTH, VOXEL, mesh_at, no_image
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, in_seconds, make_report
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Style
from hairpipe.laws.settings import BodyContact
from hairpipe.levelset.bake import bake
from hairpipe.particles.contact import look
from hairpipe.particles.interaction import exchange, find_pairs
from hairpipe.particles.links import LinkRule, link, measure_links, stiffen, turn_directions
from hairpipe.particles.model import Moving, inverse_masses
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Fibre, Interaction, ParticleSettings
from hairpipe.particles.simulate import ParticleSimulation, Prepared, find_acting, prepare
from hairpipe.particles.step import advance
from hairpipe.shot.build import bodies_of
from hairpipe.shot.shot import Frame, next_state
from hairpipe.values import Body, Particles
from hairpipe.values.hair import ParticleState
from hairpipe.values.painting import Canvas, PaintedMetres

T = TypeVar("T")
PARTS = ("search", "pairs", "directions", "stiffness", "solve", "body")
"""Neighbours; what they exchange; directions; stiffness; the steps, stiffness included; bodies, and a look at all."""
STRANDS, EACH, SEGMENTS = 6_000, 8, 25
"""Hairs that particles are chosen of, at least; particles a hair where there are more; segments of a hair."""
RULE = LinkRule(12, 0.5, 58.0, 24.0)
CROWD, LINKS, PASSES = 2_500, 15_000, 400
"""The link pass: its particles, links, and repeats, of which the best counts."""


def measure_particles(
    echo: Echo,
    counts: tuple[int, ...] = (500, 2_000, 20_000, 200_000),
    steps: tuple[int, ...] = (1, 2),
    settling: int = 3,
    frames: int = 12,
) -> Report:
    """Measure every case on one thread, and report progress.

    counts    of particles, about
    steps     a frame
    settling  frames before the first that is measured
    frames    that are measured
    """
    before = numba.get_num_threads()
    cases = list[Case]()
    parts = list[Case]()
    passes = list[float]()
    numba.set_num_threads(1)
    try:
        echo(f"a head, frames: {settling + frames}")
        bust = build_bust()
        shot = frames_of(bust, settling + frames)
        for count in counts:
            echo(f"{count:,} particles")
            particles = particles_on(bust, count)
            for number in steps:
                case, shares = measure_frames(particles, shot, number, settling)
                cases.append(case)
                parts.append({"particles": case["particles"], "steps": number, **in_seconds(shares, 1e3, "ms")})
                passes.append(link_pass())
    finally:
        numba.set_num_threads(before)
    return make_report(__name__, {"frames": cases, "parts": parts, "link pass": [{"link [ns]": 1e9 * min(passes)}]})


def particles_on(bust: Body, count: int) -> Particles:
    """Choose about so many particles in the long hair of a bust."""
    style = Style(length=PaintedMetres(LENGTH))
    strands = max(STRANDS, count // EACH)
    groom = grow(Canvas(bust, no_image, 0), style, None, strands, Cut(SEGMENTS))
    return link(sample(groom, count, "strands", 0), RULE, Fibre().line_density)


def frames_of(bust: Body, count: int) -> list[Frame]:
    """Make so many frames of a bust that turns to and fro."""
    meshes = [mesh_at(bust, frame / FPS) for frame in range(count + 1)]
    surfaces = [bake(mesh, VOXEL, HALF_WIDTH) for mesh in meshes]
    pairs = enumerate(zip(pairwise(meshes), pairwise(surfaces), strict=True))
    return [Frame(drivers, (around,), (), frame / FPS, 1 / FPS) for frame, (drivers, around) in pairs]


def measure_frames(
    particles: Particles, frames: list[Frame], steps: int, settling: int
) -> tuple[Case, dict[str, float]]:
    """Simulate a shot; return the times of its frames, but for the first ones, and of their parts [s], each alone."""
    settings = ParticleSettings(steps=steps, interaction=Interaction())
    prepared = prepare(particles, settings)
    simulation = ParticleSimulation(particles, prepared, settings)
    state = next_state(simulation, None, frames[0])
    times = list[float]()
    shares = list[dict[str, float]]()
    counts = list[tuple[int, int]]()
    next_state(simulation, state, frames[0])  # which may compile, or load what was
    parts_of(particles, prepared, state, frames[0], settings)  # as may what is called alone there
    for number, frame in enumerate(frames):
        before = state
        seconds, state = timed(lambda given=(before, frame): next_state(simulation, *given))
        if number >= settling:
            times.append(seconds)
            found, count = parts_of(particles, prepared, before, frame, settings)
            shares.append(found)
            counts.append(count)
    pairs, iterations = np.mean(counts, axis=0)
    model = prepared.model
    free = len(model.masses) - model.deep
    case: Case = {
        "particles": free,
        "links": len(model.links.ends),
        "pairs": round(float(pairs)),
        "steps": steps,
        "iterations": float(iterations),
        "median [ms]": 1e3 * float(np.median(times)),
        "least [ms]": 1e3 * min(times),
        "least for each [us]": 1e6 * min(times) / free,
    }
    return case, {part: float(np.median([share[part] for share in shares])) for part in PARTS}


def parts_of(
    particles: Particles, prepared: Prepared, state: ParticleState, frame: Frame, settings: ParticleSettings
) -> tuple[dict[str, float], tuple[int, int]]:
    """Do each part of a frame alone; return its seconds, and the numbers of pairs and of iterations."""
    model = prepared.model
    axial = prepared.springs.axial
    law = prepared.law
    assert law is not None
    points = state.points
    dt = frame.frame_dt
    count = len(model.links.ends)
    inverses = inverse_masses(model)
    ways = np.empty((count, 4))
    stiffness = np.empty(count)
    search, pairs = timed(lambda: find_pairs(model.masses, points, model.range))
    swapped = state.velocities.copy()
    exchanged, _ = timed(lambda: exchange(law, pairs, inverses, points, state.directions, dt, swapped))
    contact = BodyContact(settings.contact.friction, settings.contact.thickness)
    body, bodies = timed(lambda: bodies_of(frame.surfaces, frame.parts, contact, dt))
    acting = find_acting(ParticleSimulation(particles, prepared, settings), state, frame, bodies)
    looking, _ = timed(lambda: look(bodies, acting.places, dt, model.deep))
    stiffening, _ = timed(
        lambda: (measure_links(model.links, points, ways), stiffen(model.links, model.reach, axial, ways, stiffness))
    )
    turning, _ = timed(lambda: turn_directions(model.links, ways, stiffness, model.deep, state.directions.copy()))
    moving = Moving(points.copy(), state.velocities.copy(), state.tensions.copy())
    solving, iterations = timed(
        lambda: advance(
            model, prepared.springs, acting.forces, acting.planes, acting.roots, dt / settings.steps, moving
        )
    )
    seconds = search, exchanged, turning, stiffening, solving, body + looking
    return dict(zip(PARTS, seconds, strict=True)), (len(pairs.ends), iterations)


def timed(work: Callable[[], T]) -> tuple[float, T]:
    """Do some work; return its processor time [s], less what the clock takes, and its result.

    No garbage is collected meanwhile: a part of a small frame takes tens of microseconds.
    """
    gc.disable()
    try:
        begun = time.thread_time()
        found = work()
        return time.thread_time() - begun - clock_cost(), found
    finally:
        gc.enable()


@cache
def clock_cost() -> float:
    """Return the processor time of looking at the clock [s], which some systems have tens of microseconds for."""
    looks = [time.thread_time() for _ in range(100)]
    return min(after - before for before, after in pairwise(looks))


def link_pass() -> float:
    """Return the best time of a link [s] in a pass over random links of a small cloud: force, and scatter."""
    rng = np.random.default_rng(0)
    points = rng.random((CROWD, 3))
    ends = rng.integers(0, CROWD, (LINKS, 2))
    forces = np.zeros((CROWD, 3))
    ends = ends[ends[:, 0] != ends[:, 1]].astype(np.int32)
    _pull(points, ends, forces)
    return min(timed(lambda: _pull(points, ends, forces))[0] for _ in range(PASSES)) / len(ends)


@njit(cache=True, error_model="numpy")
def _pull(points: np.ndarray, ends: np.ndarray, forces: np.ndarray) -> None:
    """Add the force of every link to both its ends, in place."""
    for e in range(len(ends)):
        i, j = ends[e, 0], ends[e, 1]
        way = minus(row(points, j), row(points, i))
        force = scaled(1.0 - 0.1 / length(way), way)
        for c in range(3):
            forces[i, c] += force[c]
            forces[j, c] -= force[c]
