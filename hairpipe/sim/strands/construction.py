"""Settings of the construction of a strand's network, with proven defaults."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.units import Degrees, Ge, Interval


@dataclass(frozen=True)
class Construction:
    """The lattice of a strand and its springs, for experiments with their parts.

    turn           angle of the perturbed particles about the axis from segment to segment, reversed every five; 0
                   leaves the network floppy, 90 puts two altitude springs at rest in one place
    off_axis_mass  share of the mass on the perturbed particles; the published third slows torsion
    bending        factor on the bending constant of the material; 0 removes the bending springs
    torsion        factor on the torsion constant of the material; 0 removes the torsion springs
    altitude       ratio of the altitude constant to the torsion constant; 0 lets long hair collapse
    """

    turn: Annotated[Degrees, Interval(ge=0.0, le=180.0)] = 72.0
    off_axis_mass: Annotated[float, Interval(gt=0.0, le=0.5)] = 0.05
    bending: Annotated[float, Ge(0.0)] = 1.0
    torsion: Annotated[float, Ge(0.0)] = 1.0
    altitude: Annotated[float, Interval(ge=0.0, le=10.0)] = 0.4
