"""What solids and shells are made of, and which altitude springs they get."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.units import Interval, KilogramsPerCubicMetre, Metres, Pascals, Seconds

Altitudes = Literal["selected", "faces", "none"]


@dataclass(frozen=True)
class Rubber:
    """Material of a solid; the springs give a material of Poisson ratio 1/4.

    young      Young's modulus of the material
    density    mass density of the material
    damping    relaxation time of a stretch without inertia
    altitudes  altitude springs: selected as published in 2008, all four faces of each tetrahedron as in 2003, or none
    """

    young: Annotated[Pascals, Interval(ge=0.0, le=1e12)] = 4e5
    density: Annotated[KilogramsPerCubicMetre, Interval(gt=0.0, le=1e5)] = 1000.0
    damping: Annotated[Seconds, Interval(ge=0.0, le=10.0)] = 0.01
    altitudes: Altitudes = "selected"


@dataclass(frozen=True)
class Fabric:
    """Material of a shell; the springs give a sheet of Poisson ratio 1/3.

    young      Young's modulus of the material
    thickness  thickness of the sheet, of bending stiffness young thickness^3 / (12 (1 - 1/9))
    density    mass density of the material
    damping    relaxation time of a stretch without inertia
    across     stiffness ratio of the bending spring across an edge to the spring along the edge
    altitudes  altitude springs: selected as published in 2008 (restores inverted shells), faces as in 2003, or none
    """

    young: Annotated[Pascals, Interval(ge=0.0, le=1e12)] = 1e7
    thickness: Annotated[Metres, Interval(gt=0.0, le=1.0)] = 0.02
    density: Annotated[KilogramsPerCubicMetre, Interval(gt=0.0, le=1e5)] = 1000.0
    damping: Annotated[Seconds, Interval(ge=0.0, le=10.0)] = 0.01
    across: Annotated[float, Interval(ge=0.0, le=10.0)] = 0.1
    altitudes: Altitudes = "selected"
