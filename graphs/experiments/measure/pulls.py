"""A strand that is pulled along a surface by its root: it slides from the root on, and as a whole beyond a force."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.measure.tensions import first_strand, frames_between
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

COLUMNS = (
    "time [s]",
    "root moved [mm]",
    "force [uN]",
    "theory [uN]",
    "difference [% of the sliding force]",
    "tip moved [mm]",
)
GRAVITY = 9.81
PLACE = 1
"""Segment whose tension is measured: the first may be held."""


class Bar(NamedTuple):
    """A straight bar on a rough floor, of a length [m] and an axial stiffness E A [N].

    grip  friction of a metre of it, mu w [N/m]
    """

    length: float
    axial: float
    grip: float

    def force(self, moved: float, arc: float) -> float:
        """Return the tension at an arc length from an end that was moved outwards [m], slowly and always onwards [N].

        The sliding part has the tension of its friction, F(s) = F(0) - g s, and the end has moved by its elongation:
        F(0) = sqrt(2 E A g u), up to g L, where the whole bar slides.
        """
        pulled = min(float(np.sqrt(2.0 * self.axial * self.grip * moved)), self.grip * self.length)
        return max(pulled - self.grip * arc, 0.0)


def pulled_table(
    groom: Groom,
    states: Mapping[int, HairState],
    fps: float,
    window: tuple[float, float],
    bar: tuple[float, Material, float],
) -> Table:
    """Return a row for every frame of a window of time [s] about strand 0, straight, and pulled along a level floor.

    force       tension of the second segment
    theory      that of a bar
    difference  of both, over the force when all slides

    bar  friction coefficient, material, and number of segments at the root that cannot be stretched

    BadInput where no frame is in the window.
    """
    friction, material, held = bar
    frames = list(states)
    start, _ = first_strand(groom, states[frames[0]])
    whole = float(np.linalg.norm(start[-1] - start[0]))
    step = whole / (len(start) - 1)
    ideal = Bar(whole - held * step, material.axial, friction * material.line_density * GRAVITY)
    arc = (PLACE + 0.5 - held) * step
    sliding = ideal.grip * (ideal.length - arc)
    rows = []
    for frame, time in frames_between(frames, fps, window):
        points, pulls = first_strand(groom, states[frame])
        moved, tip = (float(np.linalg.norm(points[k] - start[k])) for k in (0, -1))
        theory = ideal.force(moved, arc)
        force = float(pulls[PLACE])
        rows.append((time, 1e3 * moved, 1e6 * force, 1e6 * theory, 100.0 * (force - theory) / sliding, 1e3 * tip))
    return table_of_rows(COLUMNS, rows)
