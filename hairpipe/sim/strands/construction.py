"""How the network of a strand is built; the defaults are what works."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.units import Degrees, Ge, Interval


@dataclass(frozen=True)
class Construction:
    """The lattice of a strand and the springs on it: to take apart what the model consists of.

    turn           of the perturbed particles about the axis from segment to segment, whose sense reverses every five;
                   0 leaves the network floppy, 90 ties two altitude springs at rest
    off_axis_mass  share of the mass on the perturbed particles; a third as published slows torsion
    bending        factor on the constant of the bending springs that the material gives; 0 takes them away
    torsion        factor on that of the torsion springs
    altitude       constant of the altitude springs over that of the torsion springs; with 0 a long hair collapses
    """

    turn: Annotated[Degrees, Interval(ge=0.0, le=180.0)] = 72.0
    off_axis_mass: Annotated[float, Interval(gt=0.0, le=0.5)] = 0.05
    bending: Annotated[float, Ge(0.0)] = 1.0
    torsion: Annotated[float, Ge(0.0)] = 1.0
    altitude: Annotated[float, Interval(ge=0.0, le=10.0)] = 0.4
