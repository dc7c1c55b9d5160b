"""The bar that is driven through a tuft of particles: as strands are met, in frames of one step each."""

from dataclasses import replace

import numpy as np

from hairpipe.graphs.experiments.studies.contact.bar import axis_at, bar_at, roots_at, went_across
from hairpipe.graphs.experiments.studies.contact.cloud_energy import energy_of, work_on_links
from hairpipe.graphs.experiments.studies.contact.worst import Seen, Worst
from hairpipe.particles.settings import ParticleSettings
from hairpipe.particles.simulate import ParticleSimulation, Prepared, prepare
from hairpipe.shot.shot import Frame, next_state
from hairpipe.values import Particles


def meet(particles: Particles, settings: ParticleSettings, speed: float, rate: int, seconds: float) -> Worst:
    """Drive the bar through particles at a speed [m/s]; a run that is not finite ends there.

    rate  frames a second: bodies are found once in each, however many steps it has
    """
    prepared = prepare(particles, settings)
    settings = replace(settings, steps=1)
    held = np.flatnonzero(np.isfinite(prepared.model.links.keeps))
    worst = Worst(np.zeros(len(held), bool), simulated=len(particles.points) - prepared.model.deep)
    mass = prepared.model.masses[prepared.model.deep :].sum()
    work = 0.0
    start = _frame(particles, speed, -1, rate)
    simulation = ParticleSimulation(particles, prepared, settings)
    state = next_state(simulation, None, start)
    with np.errstate(all="ignore"):
        for frame in range(round(seconds * rate)):
            before = state.points
            began = axis_at(speed, frame / rate)[0]
            try:
                state = next_state(simulation, state, _frame(particles, speed, frame, rate))
            except ArithmeticError:
                worst.finite = False
                break
            axis = axis_at(speed, (frame + 1) / rate)[0]
            worst.steps += 1
            seen = _seen(prepared, held, state.points, state.velocities, axis)
            worst.note(seen)
            worst.through |= went_across(before - began, state.points - axis, prepared.model.links.ends[held])
            work += work_on_links(prepared.model, prepared.springs, before, state.points)
            worst.end_frame((frame + 1) / rate, seen, (energy_of(prepared, state, settings.gravity) + work) / mass)
    return worst


def _frame(particles: Particles, speed: float, frame: int, rate: int) -> Frame:
    """Return the frame after so many, of so many a second; its motion of the roots is that of strands."""
    began = frame / rate
    ended = (frame + 1) / rate
    drivers = roots_at(particles.hair, speed, began), roots_at(particles.hair, speed, ended)
    return Frame(drivers, (), [(bar_at(speed, began), bar_at(speed, ended))], began, 1.0 / rate)


def _seen(prepared: Prepared, held: np.ndarray, points: np.ndarray, velocities: np.ndarray, axis: np.ndarray) -> Seen:
    """Return what is seen of particles; what is stretched is the link that holds each, over its length in the groom."""
    links, free = prepared.model.links, prepared.model.deep
    ways = np.diff(points[links.ends[held]], axis=1)[:, 0]
    stretch = float((np.linalg.norm(ways, axis=1) / links.lengths[held]).max()) - 1.0
    return Seen(points[free:], velocities[free:], stretch, axis)
