"""What solids and shells are made of, and which altitude springs they get."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.units import Interval, KilogramsPerCubicMetre, Metres, Pascals, Seconds

Altitudes = Literal["selected", "faces", "none"]


@dataclass(frozen=True)
class Rubber:
    """Matter of a solid; its springs make a material of Poisson ratio 1/4.

    young      Young's modulus
    density    of the matter
    damping    time in which a stretch would creep back without inertia
    altitudes  selected as published in 2008; faces, the four of every tetrahedron at once, as in 2003; none
    """

    young: Annotated[Pascals, Interval(ge=0.0, le=1e12)] = 4e5
    density: Annotated[KilogramsPerCubicMetre, Interval(gt=0.0, le=1e5)] = 1000.0
    damping: Annotated[Seconds, Interval(ge=0.0, le=10.0)] = 0.01
    altitudes: Altitudes = "selected"


@dataclass(frozen=True)
class Fabric:
    """Matter of a shell; its springs make a sheet of Poisson ratio 1/3.

    young      Young's modulus
    thickness  of the sheet; it resists bending with young thickness^3 / (12 (1 - 1/9))
    density    of the matter
    damping    time in which a stretch would creep back without inertia
    across     stiffness of the bending spring between the vertices opposite to an edge, over that of an edge
    altitudes  selected as published in 2008, which bend the shell back; faces as in 2003; none
    """

    young: Annotated[Pascals, Interval(ge=0.0, le=1e12)] = 1e7
    thickness: Annotated[Metres, Interval(gt=0.0, le=1.0)] = 0.02
    density: Annotated[KilogramsPerCubicMetre, Interval(gt=0.0, le=1e5)] = 1000.0
    damping: Annotated[Seconds, Interval(ge=0.0, le=10.0)] = 0.01
    across: Annotated[float, Interval(ge=0.0, le=10.0)] = 0.1
    altitudes: Altitudes = "selected"
