"""A cantilever under its own weight: the tip compared with that of the elastica."""

from collections.abc import Iterable, Sequence

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Specimen, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import Balance, balance, motions
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

_FACTOR = 2.0
"""Most that the weight grows from one equilibrium to the next."""
COLUMNS = ("strand", "segments", "from hanging [deg]", "Gamma", "tip error [% of length]", "no equilibrium")


def cantilever_table(
    sample: Sample, segments: Sequence[int], angles: Sequence[float], rolls: int, gammas: Sequence[float]
) -> Table:
    """Tabulate the distance of the tip from the elastica's, the worst over the rolls.

    angles  of the clamp from hanging straight down [deg]
    rolls   of the strand about its axis, in so many equal steps of half a turn
    gammas  rho A g L^3 / (E I), ascending
    """
    rows = []
    for count in segments:
        specimen = straight_specimen(sample, count)
        for angle in angles:
            sags = [list(sag(specimen, np.deg2rad(angle), roll, gammas)) for roll in np.pi * np.arange(rolls) / rolls]
            for gamma, found in zip(gammas, zip(*sags, strict=True), strict=True):
                worst = 100 * max(error for _, error in found)
                lost = sum(not at.found for at, _ in found)
                rows.append((f"{sample.name(count)}, {angle:g} deg", count, angle, gamma, worst, lost))
    return table_of_rows(COLUMNS, rows)


def sag(specimen: Specimen, angle: float, roll: float, gammas: Iterable[float]) -> Iterable[tuple[Balance, float]]:
    """Follow a strand as it grows heavier: for every Gamma its equilibrium, and the tip's error over the length.

    angle  of the clamp from hanging [rad]; roll  of the strand about its axis [rad]
    """
    length = specimen.segment * specimen.segments
    aside = np.array([np.cos(roll), np.sin(roll), 0.0])
    axis = np.array([0.0, 0.0, 1.0])
    down = np.cos(angle) * axis - np.sin(angle) * aside
    level = np.sin(angle) * axis + np.cos(angle) * aside
    free = motions(specimen)
    at_gamma = 0.0
    at = Balance(specimen.rest, 0.0)
    weight = specimen.weight(down * specimen.material.bending / (specimen.material.line_density * length**3))
    for gamma in gammas:
        while at_gamma < gamma:
            at_gamma = gamma if at_gamma == 0 else min(gamma, _FACTOR * at_gamma)
            at = balance(specimen, at.pose, at_gamma * weight, free)
        tip = bend_elastica(gamma, angle - np.pi / 2).tip
        away = at.pose.x[specimen.tip] - length * (tip[0] * level - tip[1] * down)
        yield at, float(np.linalg.norm(away) / length)
