"""Material of hair, and its elastic rod."""

from dataclasses import dataclass
from math import pi
from typing import Annotated

from hairpipe.units import Interval, KilogramsPerCubicMetre, Metres, Pascals


@dataclass(frozen=True)
class Material:
    """A solid round fibre. The defaults are human scalp hair.

    diameter    diameter of the fibre
    young       Young's modulus of the fibre
    poisson     Poisson ratio of the fibre; the shear modulus is young / (2 (1 + poisson))
    density     mass density of the fibre
    softening   divisor of the axial stiffness, for longer time steps: the strain of real hair under its weight is only
                1e-6; at 100 the error of a swing is 0.6 % of the length
    """

    diameter: Annotated[Metres, Interval(ge=1e-5, le=2e-3)] = 80e-6
    young: Annotated[Pascals, Interval(ge=1e6, le=1e12)] = 3.9e9
    poisson: Annotated[float, Interval(ge=0.0, le=0.5)] = 0.35
    density: Annotated[KilogramsPerCubicMetre, Interval(ge=10.0, le=1e4)] = 1310.0
    softening: Annotated[float, Interval(ge=1.0, le=1e4)] = 100.0

    @property
    def axial(self) -> float:
        """EA, softened [N]."""
        return self.young * pi * self.diameter**2 / 4 / self.softening

    @property
    def bending(self) -> float:
        """EI [N m^2]."""
        return self.young * pi * self.diameter**4 / 64

    @property
    def torsion(self) -> float:
        """GJ of a round section: EI / (1 + poisson) [N m^2]."""
        return self.bending / (1 + self.poisson)

    @property
    def line_density(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * pi * self.diameter**2 / 4
