"""A trial in steps of one length: the paths of the tips, and the extremes over all steps."""

from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from hairpipe.graphs.experiments.studies.integrators.energy import energies
from hairpipe.graphs.experiments.studies.integrators.leading import ends_at, groom_of
from hairpipe.graphs.experiments.studies.integrators.trial import MOTIONS, Strand, Trial
from hairpipe.laws.settings import Air, Drag, Scheme, StrainLimit
from hairpipe.shot.build import integrator_of
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start
from hairpipe.solve.boundary import ClampPath, clamp_at
from hairpipe.solve.stage import State, Step
from hairpipe.solve.stretch import StrainFilter
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.hair_model import HairModel, build_hair

RATE = 24
"""Samples a second; between two of them roots are led along a cubic, and steps are equal shares of that time."""


@dataclass(frozen=True, eq=False)
class Course:
    """What strands did, sample by sample from the start on; what is worst is so since the sample before.

    tips     [m], (samples, strands, 3)
    energy   above that of a strand that hangs unstretched, over m g L, (samples, strands); see `energies`
    kinetic  energy, the largest, over m g L, same shape
    stretch  of a segment, the largest, over its length, same shape
    speed    of a particle, the largest [m/s], same shape
    way      of a particle in a step over the time that it takes, the largest [m/s], same shape
    """

    tips: np.ndarray
    energy: np.ndarray
    kinetic: np.ndarray
    stretch: np.ndarray
    speed: np.ndarray
    way: np.ndarray


def follow(trial: Trial, scheme: Scheme, strain: StrainLimit | None, step: float) -> Course:
    """Put strands through a trial in steps of at most this length [s]."""
    strands = trial.strands
    found: list[list[np.ndarray]] = []
    for drag, group in groupby(strands, lambda strand: MOTIONS[strand.motion].drag):
        found.append(_follow(trial, list(group), Scene(air=Air(Drag(drag)), strain=strain, scheme=scheme), step))
    return Course(*(np.concatenate(parts, axis=1) for parts in zip(*found, strict=True)))


def _follow(trial: Trial, strands: list[Strand], scene: Scene, step: float) -> list[np.ndarray]:
    """Follow strands in one kind of air: the fields of their course, (samples, strands, ...) each."""
    hair = build_hair(groom_of(strands, trial.segments), trial.material, trial.model)
    frame = 1.0 / RATE
    count = max(int(np.ceil(frame / step - 1e-6)), 1)
    times = np.arange(round(trial.seconds * RATE) + 1) * frame
    state = start(hair, ends_at(strands, hair.groom, 0.0), scene)
    motion = State.begin(state, state.positions)
    unit = trial.material.line_density * scene.gravity * np.array([strand.length for strand in strands]) ** 2
    integrator = integrator_of(scene)
    limits = [] if scene.strain is None else [StrainFilter(hair.model, scene.strain.tolerance)]
    around = Surroundings(hair.model, hair.layout, limits)
    held = [clamp_at(ends_at(strands, hair.groom, time), hair.groom, hair.rest, hair.layout) for time in times]
    rows = [_sample(hair, motion, _worst(hair, motion, motion.x, frame), scene, unit)]
    with np.errstate(all="ignore"):
        for before, after in pairwise(held):
            path = ClampPath(before, after, frame)
            worst = np.zeros((4, *hair.layout.strands.shape))
            for n in range(count):
                x = motion.x.copy()
                integrator.advance(hair.model, motion, Step(path, n * frame / count, frame / count), around)
                worst = np.maximum(worst, _worst(hair, motion, x, frame / count))
            rows.append(_sample(hair, motion, worst, scene, unit))
    return [np.stack(values) for values in zip(*rows, strict=True)]


def _worst(hair: HairModel, motion: State, before: np.ndarray, dt: float) -> np.ndarray:
    """Kinetic energy, stretch, speed and way of a step, the largest of every strand, (4, blocks, W)."""
    blocks, shape = hair.layout.blocks, hair.model.shape
    x, v, w, mass = (a.reshape(blocks, -1, *a.shape[1:]) for a in (motion.x, motion.v, before, hair.model.mass))
    squares = np.einsum("bpcl,bpcl->bpl", v, v)
    kinetic = 0.5 * np.einsum("bpl,bpl->bl", mass[:, shape.clamped :], squares[:, shape.clamped :])
    moved = x - w
    way = np.einsum("bpcl,bpcl->bpl", moved, moved).max(1)
    axis = x[:, shape.axis]
    edges = axis[:, 1:] - axis[:, :-1]
    rest = hair.model.inverse_lengths[:, shape.stride - 1].reshape(blocks, -1, x.shape[3])
    rest = rest[:, shape.axis][:, : edges.shape[1]]
    stretch = np.sqrt(np.einsum("bpcl,bpcl->bpl", edges, edges)) * rest
    return np.stack([kinetic, stretch.max(1) - 1.0, np.sqrt(squares.max(1)), np.sqrt(way) / dt])


def _sample(
    hair: HairModel, motion: State, worst: np.ndarray, scene: Scene, unit: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Collect a sample in the order of the fields of Course, each (strands, ...)."""
    place = np.empty(len(hair.groom.ids), int)
    place[hair.layout.strands.reshape(-1)] = np.arange(hair.layout.strands.size)
    kinetic, *rest = (values.reshape(-1)[place] for values in worst)
    tips = hair.layout.axis(motion.x)[hair.groom.offsets[1:] - 1]
    energy = energies(hair, motion, scene.gravity).reshape(-1)[place]
    return tips, energy / unit + 0.5, kinetic / unit, *rest
