"""The tension of a loose knot in a strand without friction: what it takes to hold a loop of a given size.

Such a knot is nearly a circle of radius R, in whose braid the strand touches itself. It has the energy pi E I / R, and
brings the ends nearer by 2 pi R: they are pulled by E I / (2 R^2) (Audoly, Clauvelin, Neukirch, Phys. Rev. Lett. 99,
164301, 2007). This is the limit of a thin strand: the braid adds a part of the order of sqrt(thickness / R). Whatever
the thickness, T + E I k^2 / 2 is the same all along a strand of tension T and curvature k, since what touches it pushes
across it, and not along.
"""

from collections.abc import Mapping

import numpy as np

from hairpipe.graphs.experiments.studies.knots.tails import mean_over, seen_between
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

COLUMNS = ("radius [mm]", "tension [uN]", "theory [uN]", "tension error [%]", "loop error [%]", "speed [mm/s]")


def loop_table(
    groom: Groom, states: Mapping[int, HairState], fps: float, window: tuple[float, float], material: Material
) -> Table:
    """Return one row about strand 0, of means over the frames of a window of time [s].

    radius   of the loop: the length of the strand, less the distance of its ends, over 2 pi
    tension  of the tails, and its error against a thin strand
    loop     T + E I k^2 / 2 in the middle of the loop: its error against the tension of the tails
    speed    largest of a point
    """
    seen = seen_between(groom, states, fps, window)
    radius = mean_over(seen, lambda one: (one.length - one.span) / (2.0 * np.pi))
    tension = mean_over(seen, lambda one: one.tension)
    theory = pull_of(material.bending, radius)
    loop = mean_over(seen, lambda one: one.middle + 0.5 * material.bending * one.bend)
    errors = 100.0 * (tension / theory - 1.0), 100.0 * (loop / tension - 1.0)
    speed = max(one.speed for one in seen)
    return table_of_rows(COLUMNS, [(1e3 * radius, 1e6 * tension, 1e6 * theory, *errors, 1e3 * speed)])


def pull_of(bending: float, radius: float) -> float:
    """Return the tension of a loop of a radius [m] in a thin rod of a bending stiffness [N m^2]: [N]."""
    return 0.5 * bending / radius**2
