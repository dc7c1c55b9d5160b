"""Errors of a scheme against the converged run, and its failures."""

from collections.abc import Sequence

import numpy as np

from hairpipe.graphs.experiments.studies.integrators.follow import RATE, Course, follow
from hairpipe.graphs.experiments.studies.integrators.record import course_of
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.laws.settings import Scheme, StrainLimit
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

SOLVES = {"tr_bdf2": 2, "bdf2": 1, "backward_euler": 1, "nine_steps": 2}
"""Solves of a step; what a guard adds is not counted."""
STRETCHED = 0.1
ENERGETIC, ENERGETIC_LEAST = 3.0, 0.02
"""A kinetic energy above this multiple of the largest of the converged run, plus this part of m g L, is an error."""
HIDDEN, HIDDEN_LEAST = 2.0, 1.0
"""A velocity above this multiple of the speed at which particles move, plus this much [m/s], is hidden."""
COLUMNS = (
    "motion",
    "length [m]",
    "step [s]",
    "solves [1/s]",
    "tip error [% of length]",
    "energy kept",
    "energy against truth [%]",
    "stretch [%]",
    "speed [m/s]",
    "fastest way [m/s]",
    "failed",
)


def error_table(
    truth: Table, trial: Trial, scheme: Scheme, strain: StrainLimit | None, rates: Sequence[int], most: float
) -> Table:
    """Tabulate error, energy and failures of every strand at every rate of steps [1/s].

    most  solves a run may have; a longer one is not run, which its rows say
    """
    true = course_of(truth, trial)
    rows = []
    for rate in rates:
        count = -(-rate // RATE)
        solves = RATE * (count * SOLVES[scheme.value] + (scheme.value == "bdf2")) * scheme.iterations
        affordable = solves * trial.seconds <= most
        course = follow(trial, scheme, strain, 1.0 / rate) if affordable else None
        for n, strand in enumerate(trial.strands):
            values = _judged(course, true, n, strand.length) if course else (*[np.nan] * 6, "not run")
            rows.append((strand.motion, strand.length, 1.0 / (RATE * count), solves, *values))
    return table_of_rows(COLUMNS, rows)


def _judged(course: Course, true: Course, n: int, length: float) -> tuple[float | str, ...]:
    """Compare the course of strand n: the last seven columns of a row."""
    with np.errstate(all="ignore"):
        away = np.linalg.norm(course.tips[1:, n] - true.tips[1:, n], axis=1)
        error = 100 * np.sqrt(np.mean(away**2)) / length
        first, last, right = course.energy[0, n], course.energy[-1, n], true.energy[-1, n]
        kept = last / first if first > ENERGETIC_LEAST else np.nan
        against = 100 * (last / right - 1) if right > ENERGETIC_LEAST else np.nan
        stretch, speed, way, kinetic = (
            float(np.max(values[:, n])) for values in (course.stretch, course.speed, course.way, course.kinetic)
        )
    finite = np.isfinite([error, last, stretch, speed, way, kinetic]).all()
    signs = {
        "stretch": stretch > STRETCHED,
        "energy": kinetic > ENERGETIC * np.max(true.kinetic[:, n]) + ENERGETIC_LEAST,
        "hidden velocity": speed > HIDDEN * way + HIDDEN_LEAST,
    }
    failed = ", ".join(sign for sign, seen in signs.items() if seen) if finite else "NaN"
    return float(error), float(kept), float(against), 100 * stretch, speed, way, failed
