"""A strand that is pulled along a surface by its root: it slides from the root on, and as a whole beyond a force."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hairpipe.data import Groom, Table
from hairpipe.data.hair import HairState
from hairpipe.data.table import table_of_rows
from hairpipe.measure.tension import layout_of, tensions
from hairpipe.sim.material import Material

COLUMNS = ("time [s]", "root moved [mm]", "force [uN]", "theory [uN]", "difference [% of the sliding force]", "tip moved [mm]")
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

        The part that slides has the tension of its friction, F(s) = F(0) - g s; of the elongation of that part, the
        displacement of the end, F(0) = sqrt(2 E A g u) follows, up to g L, when the whole bar slides.
        """
        pulled = min(float(np.sqrt(2.0 * self.axial * self.grip * moved)), self.grip * self.length)
        return max(pulled - self.grip * arc, 0.0)


def pulled_table(
    groom: Groom, states: Mapping[int, HairState], fps: float, friction: float, material: Material, held: float
) -> Table:
    """Return a row for every frame about strand 0, straight on a level floor, whose root is moved away from its tip.

    force       tension of the second segment
    theory      that of the bar; one that sticks cannot move before, and one that slides has this force at any speed
    difference  of both, over the force when all slides

    held  number of segments at the root that cannot be stretched
    """
    frames = list(states)
    layout = layout_of(groom, states[frames[0]])
    start = next(points for strand, points, _ in tensions(layout, states[frames[0]]) if strand == 0)
    segments = len(start) - 1
    whole = float(np.linalg.norm(start[-1] - start[0]))
    step = whole / segments
    bar = Bar(whole - held * step, material.axial, friction * material.line_density * GRAVITY)
    arc = (PLACE + 0.5 - held) * step
    sliding = bar.grip * (bar.length - arc)
    rows = []
    for frame in frames:
        points, pulls = next((points, pulls) for strand, points, pulls in tensions(layout, states[frame]) if strand == 0)
        moved, tip = (float(np.linalg.norm(points[k] - start[k])) for k in (0, -1))
        theory = bar.force(moved, arc)
        force = float(pulls[PLACE])
        time = (frame - frames[0]) / fps
        rows.append((time, 1e3 * moved, 1e6 * force, 1e6 * theory, 100.0 * (force - theory) / sliding, 1e3 * tip))
    return table_of_rows(COLUMNS, rows)
