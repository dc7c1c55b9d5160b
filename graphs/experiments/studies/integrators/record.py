"""The history of a trial as a table, and back."""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.integrators.follow import RATE, Course, follow
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.laws.settings import Scheme, StrainLimit
from hairpipe.values import Table
from hairpipe.values.table import table_of_columns

TIPS = ("x [m]", "y [m]", "z [m]")
OTHERS = {
    "energy [m g L]": "energy",
    "kinetic [m g L]": "kinetic",
    "stretch": "stretch",
    "speed [m/s]": "speed",
    "way [m/s]": "way",
}


def course_table(trial: Trial, scheme: Scheme, strain: StrainLimit | None, rate: int) -> Table:
    """Tabulate every strand at every sample; rate in steps a second."""
    course = follow(trial, scheme, strain, 1.0 / rate)
    strands = trial.strands
    samples = len(course.tips)
    columns = {
        "time [s]": np.repeat(np.arange(samples) / RATE, len(strands)),
        "motion": [strand.motion for strand in strands] * samples,
        "length [m]": [strand.length for strand in strands] * samples,
    }
    columns |= {name: course.tips[:, :, c].reshape(-1) for c, name in enumerate(TIPS)}
    return table_of_columns(columns | {name: getattr(course, key).reshape(-1) for name, key in OTHERS.items()})


def course_of(table: Table, trial: Trial) -> Course:
    """Read the course of a trial back; BadInput where the table is of another one."""
    strands = trial.strands
    samples = round(trial.seconds * RATE) + 1
    whose = [(strand.motion, strand.length) for strand in strands] * samples
    if list(zip(table.texts.get("motion", ()), table.numbers.get("length [m]", ()), strict=False)) != whose:
        raise BadInput("the converged run is of another trial", right="motions, lengths and seconds of this one")
    tips = np.stack([table.numbers[name].reshape(samples, -1) for name in TIPS], axis=2)
    return Course(tips, *(table.numbers[name].reshape(samples, -1) for name in OTHERS))
