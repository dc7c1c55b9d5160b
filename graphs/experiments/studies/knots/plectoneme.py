"""A plectoneme: a strand whose ends are turned until it coils up around itself; its torque under its tension.

Two strands that lie on each other without friction, axes 2 R apart, are helices of an angle theta to their common axis.
Their energy is stationary where the torque M and the tension T of the tails are

    M = 2 (E I / R) sin^3 theta cos theta / cos 2 theta,    T = (E I / R^2) sin^4 theta (1/2 + 1 / cos 2 theta)

(Clauvelin, Audoly, Neukirch, Macromolecules 41, 4479, 2008, and Biophys. J. 96, 3716, 2009; as a ply: Thompson, van der
Heijden, Neukirch, Proc. R. Soc. A 458, 959, 2002). The loop at the end of the coil, and what joins the coil to its
tails, are not part of this.
"""

from collections.abc import Mapping

import numpy as np

from hairpipe.graphs.experiments.studies.knots.tails import mean_over, seen_between
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Table
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

COLUMNS = (
    "writhe [1]",
    "angle [deg]",
    "tension [uN]",
    "torque [nN m]",
    "theory [nN m]",
    "torque error [%]",
    "speed [mm/s]",
)


def coiled_table(
    groom: Groom,
    states: Mapping[int, HairState],
    fps: float,
    window: tuple[float, float],
    strand: tuple[float, float, Material],
) -> Table:
    """Return one row about strand 0, of means over the frames of a window of time [s].

    strand  angle by which its tip is turned against its root [rad], distance of axes that touch [m], and material

    angle   theta of the theory, from the tension
    torque  G J over the length times the angle that is left for twist: that of the ends, less 2 pi times the writhe
    speed   largest of a point
    """
    turned, thickness, material = strand
    seen = seen_between(groom, states, fps, window)
    writhe = mean_over(seen, lambda one: one.writhe)
    tension = mean_over(seen, lambda one: one.tension)
    length = mean_over(seen, lambda one: one.length)
    torque = material.torsion * (abs(turned) - 2.0 * np.pi * abs(writhe)) / length
    angle = angle_under(tension, material.bending, 0.5 * thickness)
    theory = torque_of(angle, material.bending, 0.5 * thickness)
    state = writhe, float(np.degrees(angle)), 1e6 * tension
    error = 100.0 * (torque / theory - 1.0)
    speed = 1e3 * max(one.speed for one in seen)
    return table_of_rows(COLUMNS, [(*state, 1e9 * torque, 1e9 * theory, error, speed)])


def torque_of(angle: float, bending: float, radius: float) -> float:
    """Return the torque M of a coil [N m], of an angle [rad] and a bending stiffness [N m^2]; radius R [m]."""
    return 2.0 * bending / radius * np.sin(angle) ** 3 * np.cos(angle) / np.cos(2.0 * angle)


def tension_of(angle: float, bending: float, radius: float) -> float:
    """Return the tension T of a coil [N]; arguments as of `torque_of`."""
    return bending / radius**2 * np.sin(angle) ** 4 * (0.5 + 1.0 / np.cos(2.0 * angle))


def angle_under(tension: float, bending: float, radius: float) -> float:
    """Return the angle theta of a coil under a tension [N]: [rad]; NaN under none."""
    from scipy.optimize import root_scalar

    if not tension > 0.0:
        return np.nan
    steepest = 0.25 * np.pi * (1.0 - 1e-9)
    return float(root_scalar(lambda at: tension_of(at, bending, radius) - tension, bracket=(0.0, steepest)).root)
