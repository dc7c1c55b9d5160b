"""A strand of extreme material, size or initial state: whether it returns to rest."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.integrators.leading import groom_of
from hairpipe.graphs.experiments.studies.integrators.trial import Strand
from hairpipe.laws.settings import Air, Drag, Scheme, StepControl
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.strands.hair_model import HairModel, build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

FRAME = 1 / 24
COLUMNS = (
    "case",
    "value",
    "step [s]",
    "largest stretch [%]",
    "stretch at the end [%]",
    "speed at the end [m/s]",
    "outcome",
)
DRAG, CALM, TRUE = 20.0, 0.5, 0.02
"""Drag [1/s]; speed [m/s] and stretch at the end, beyond that by its weight, up to which a strand has come back."""
STARTS = ("scattered", "collapsed", "on a line", "mirrored")
HAIR = Material()


class Case(NamedTuple):
    """One extreme strand: which property is extreme, its value, and the strand.

    length     [m]
    gravity    [m/s^2]
    disturbed  one of STARTS; nothing without
    """

    name: str
    value: float
    material: Material = HAIR
    length: float = 0.1
    segments: int = 20
    gravity: float = 9.81
    disturbed: str = ""


def extremes_table(rates: Sequence[int], seconds: float) -> Table:
    """Tabulate the outcome for every extreme case at every rate of steps [1/s]."""
    return table_of_rows(COLUMNS, [_try(case, rate, seconds) for rate in rates for case in _cases()])


def _cases() -> Iterator[Case]:
    for factor in 10.0 ** np.arange(-4, 5):
        yield Case("stiffness, over that of hair", factor, replace(HAIR, young=factor * HAIR.young))
    yield Case("length of a soft segment [m]", 1e-4, length=2e-3)
    for size in (1e-4, 1e-3, 1e-2, 0.1, 1.0):
        material = replace(HAIR, softening=min(HAIR.softening, size / 1e-4))
        yield Case("length of a segment [m]", size, material, 20 * size)
    for segments in (1, 2, 3, 10, 100, 1000):
        yield Case("segments of 3 mm", segments, length=3e-3 * segments, segments=segments)
    yield Case("gravity [m/s^2]", 0.0, gravity=0.0)
    for how in STARTS:
        yield Case(f"at the start {how}", 1.0, disturbed=how)


def _try(case: Case, rate: int, seconds: float) -> tuple[float | str, ...]:
    """Simulate a swinging strand; return its row."""
    scene = Scene(
        case.gravity, Air(Drag(DRAG)), strain=None, steps=StepControl(1.0 / rate, np.inf, np.inf), scheme=Scheme()
    )
    begun = (case.name, case.value, 1.0 / rate)
    try:
        hair = build_hair(groom_of([Strand("swing", case.length)], case.segments), case.material, "network")
    except BadInput as error:
        return *begun, np.nan, np.nan, np.nan, f"refused: {error}".splitlines()[0]
    state = start(hair, None, scene)
    disturb(hair, state.positions, case.disturbed)
    largest, last = 0.0, 0.0
    with np.errstate(all="ignore"):
        for _ in range(round(seconds / FRAME)):
            state = advance_frame(hair, state, (None, None), (), FRAME, scene)
            last = stretch(hair, state.positions)
            largest = max(largest, last)
    speed = float(np.linalg.norm(state.velocities, axis=1).max())
    hanging = case.material.line_density * case.gravity * case.length / case.material.axial
    good = last < TRUE + hanging and speed < CALM
    outcome = "comes back" if good else "stays bent" if np.isfinite([last, speed]).all() else "not finite"
    return *begun, 100 * largest, 100 * last, speed, outcome


def disturb(hair: HairModel, positions: np.ndarray, how: str) -> None:
    """Move the free particles of a strand, (rows, 3, W) [m], in place."""
    clamped = hair.model.shape.clamped
    free = positions[clamped:]
    root = positions[clamped - 1].copy()
    segment = 1.0 / float(hair.model.inverse_lengths[0, 1, 0])
    if how == "scattered":
        free += segment * np.random.default_rng(3).normal(size=(*free.shape[:2], 1))
    elif how == "collapsed":
        free[:] = root
    elif how == "on a line":
        free[:] = root + segment / 2 * (
            np.arange(1, len(free) + 1)[:, None, None] * np.array([0.6, -0.8, 0.0])[:, None]
        )
    elif how == "mirrored":
        free[:, 2] *= -1.0


def stretch(hair: HairModel, positions: np.ndarray) -> float:
    """Largest change of length of a segment of the only strand, over its length."""
    axis = hair.layout.axis(positions)
    lengths = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    return float(np.max(np.abs(lengths * float(hair.model.inverse_lengths[0, 1, 0]) - 1.0)))
