"""Material of hair, and its elastic rod."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, Any

from hairpipe.groom.painting.painted import Varied, VariedWidth
from hairpipe.units import Interval, KilogramsPerCubicMetre, Metres, Pascals

DIAMETERS, MODULI, DENSITIES = Interval(ge=1e-5, le=2e-3), Interval(ge=1e6, le=1e12), Interval(ge=10.0, le=1e4)
Poisson = Annotated[float, Interval(ge=0.0, le=0.5)]
Softening = Annotated[float, Interval(ge=1.0, le=1e4)]


class RoundFibre:
    """Stiffness and mass of a solid round fibre: numbers, or arrays that broadcast."""

    diameter: Any
    young: Any
    poisson: float
    density: Any
    softening: float

    @property
    def axial(self) -> Any:
        """EA, softened [N]."""
        return self.young * pi * self.diameter**2 / 4 / self.softening

    @property
    def bending(self) -> Any:
        """EI [N m^2]."""
        return self.young * pi * self.diameter**4 / 64

    @property
    def torsion(self) -> Any:
        """GJ of a round section: EI / (1 + poisson) [N m^2]."""
        return self.bending / (1 + self.poisson)

    @property
    def line_density(self) -> Any:
        """Mass per length [kg/m]."""
        return self.density * pi * self.diameter**2 / 4


@dataclass(frozen=True)
class Material(RoundFibre):
    """A solid round fibre. The defaults are human scalp hair.

    diameter    diameter of the fibre
    young       Young's modulus of the fibre
    poisson     Poisson ratio of the fibre; the shear modulus is young / (2 (1 + poisson))
    density     mass density of the fibre
    softening   divisor of the axial stiffness, for longer time steps: the strain of real hair under its weight is only
                1e-6; at 100 the error of a swing is 0.6 % of the length
    """

    diameter: Annotated[Metres, DIAMETERS] = 80e-6
    young: Annotated[Pascals, MODULI] = 3.9e9
    poisson: Poisson = 0.35
    density: Annotated[KilogramsPerCubicMetre, DENSITIES] = 1310.0
    softening: Softening = 100.0


@dataclass(frozen=True)
class Diameter(VariedWidth):
    __doc__ = f"{Varied.__doc__}\n{VariedWidth.__doc__}"
    value: Annotated[Metres, DIAMETERS]
    low: Annotated[Metres, Interval(ge=0.0, le=DIAMETERS.le)] = 0.0


@dataclass(frozen=True)
class Modulus(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[Pascals, MODULI]
    low: Annotated[Pascals, Interval(ge=0.0, le=MODULI.le)] = 0.0


@dataclass(frozen=True)
class MassDensity(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[KilogramsPerCubicMetre, DENSITIES]
    low: Annotated[KilogramsPerCubicMetre, Interval(ge=0.0, le=DENSITIES.le)] = 0.0


@dataclass(frozen=True)
class VariedMaterial:
    __doc__ = Material.__doc__

    diameter: Diameter = Diameter(Material.diameter)
    young: Modulus = Modulus(Material.young)
    poisson: Poisson = Material.poisson
    density: MassDensity = MassDensity(Material.density)
    softening: Softening = Material.softening
