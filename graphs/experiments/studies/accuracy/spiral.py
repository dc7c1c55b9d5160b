"""A spiral with torsion, which hangs from its root: the way of its tip compared with Kirchhoff's rod."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.helix import turns
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Spiral
from hairpipe.graphs.experiments.studies.accuracy.specimen import Specimen, specimen_of
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, motions
from hairpipe.graphs.experiments.studies.theory.clamps import Clamp, hang_rod
from hairpipe.graphs.experiments.studies.theory.kirchhoff import Rod
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

_LONGER = 1.2
"""Length of the curve that is cut into chords, over the sum of these."""
COLUMNS = ("strand", "segments", "gravity [m/s^2]", "way [% of length]", "error of the way [%]", "no equilibrium")


def spiral_table(
    sample: Sample, spiral: Spiral, segments: Sequence[int], gravities: Sequence[float], orientations: int
) -> Table:
    """Tabulate the way of the tip from the shape without weight, for gravities along the root [m/s^2], ascending.

    orientations  that spirals of either hand are brought to, and gravity with them; errors are the largest of all, NaN
                  where one has no equilibrium
    """
    rows = []
    for count in segments:
        rod = rod_of(sample, spiral)
        points, length = cut(rod, sample.length / count, count)
        rod = replace(rod, length=length)
        cases = [(specimen_of(sample, points @ turn.T), turn) for turn in turns(orientations)]
        ways = [list(fall(specimen, gravities, turn)) for specimen, turn in cases]
        for gravity, found in zip(gravities, zip(*ways, strict=True), strict=True):
            weight = np.array([0.0, 0.0, sample.material.line_density * gravity])
            theory = hang_rod(replace(rod, weight=weight), CLAMP).points[-1] - points[-1]
            size = float(np.linalg.norm(theory))
            lost = sum(not at_rest for _, at_rest in found)
            error = np.nan if lost else max(float(np.linalg.norm(way - theory)) for way, _ in found)
            rows.append((sample.name(count), count, gravity, 100 * size / length, 100 * error / size, lost))
    return table_of_rows(COLUMNS, rows)


CLAMP = Clamp(np.zeros(3), np.eye(3))
"""Where a spiral begins, along +Z."""


def rod_of(sample: Sample, spiral: Spiral) -> Rod:
    """Return the rod without weight that is a spiral; its frame, that of Frenet, turns with the torsion."""
    material = sample.material
    natural = np.array([0.0, 1 / spiral.start, 2 * np.pi / spiral.turn])
    growth = np.array([0.0, (1 / spiral.end - 1 / spiral.start) / sample.length, 0.0])
    return Rod(sample.length, material.bending, material.torsion, natural, np.zeros(3), growth)


def cut(rod: Rod, chord: float, count: int) -> tuple[np.ndarray, float]:
    """Return points on a rod without load at equal distances [m], (count + 1, 3), and the arc up to the last one."""
    from scipy.interpolate import CubicHermiteSpline
    from scipy.optimize import root_scalar

    shape = hang_rod(replace(rod, length=_LONGER * rod.length), CLAMP)
    curve = CubicHermiteSpline(shape.arc, shape.points, shape.frames[:, :, 2])
    arc = 0.0
    points = [shape.points[0]]
    for _ in range(count):
        here = points[-1]
        bracket = (arc, arc + 1.5 * chord)
        arc = root_scalar(lambda s, at=here: np.linalg.norm(curve(s) - at) - chord, bracket=bracket).root
        points.append(curve(arc))
    return np.array(points), arc


def fall(specimen: Specimen, gravities: Sequence[float], turn: np.ndarray) -> Iterator[tuple[np.ndarray, bool]]:
    """Follow the tip as gravity grows [m/s^2]: its way before a turn [m], (3,), and whether the strand is at rest."""
    pose = specimen.rest
    free = motions(specimen)
    for gravity in gravities:
        at = balance(specimen, pose, specimen.weight(gravity * turn[:, 2]), free)
        pose = at.pose
        yield (pose.x - specimen.rest.x)[specimen.tip] @ turn, at.found
