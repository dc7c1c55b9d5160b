"""Material of hair, and its elastic rod.

Fibres of a groom: stiffness and mass at its points and on its segments, from settings that may vary.
"""
# pyright: reportCallIssue=false

from dataclasses import dataclass, fields
from math import pi
from typing import Annotated, Any, NamedTuple

import numpy as np

from hairpipe.units import Interval, KilogramsPerCubicMetre, Metres, Pascals
from hairpipe.values import Groom
from hairpipe.values.painting import ReadImage, Varied, VariedWidth, values_of

DIAMETERS, MODULI, DENSITIES = Interval(ge=1e-5, le=2e-3), Interval(ge=1e6, le=1e12), Interval(ge=10.0, le=1e4)
Poisson = Annotated[float, Interval(ge=0.0, le=2.0)]
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
    poisson     Poisson ratio of the fibre; the shear modulus is young / (2 (1 + poisson)). Hair is anisotropic, and its
                measured moduli give 1.2, beyond the 0.5 of an isotropic solid
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


class Section(NamedTuple):
    """Stiffness and mass of fibres, arrays of one shape, as of `RoundFibre`; softening of all."""

    axial: np.ndarray
    bending: np.ndarray
    torsion: np.ndarray
    line_density: np.ndarray
    softening: float


def taken(section: Section, some: np.ndarray) -> Section:
    """Return the sections of some strands, the first axis of all arrays; pure."""
    return Section(*(values[some] for values in section[:-1]), section.softening)


class Fibre(NamedTuple):
    """Fibres of strands of n segments: at their points, (s, n+1), and on their segments, (s, n)."""

    points: Section
    segments: Section


class Fibres(NamedTuple):
    """The fibres of a groom; of each quantity one number, or values at points and on the segments after them, (2, P).

    diameter  mean diameter [m]
    widths    diameters at points where they vary, (P,) float32 [m]
    """

    axial: Any
    bending: Any
    torsion: Any
    line_density: Any
    softening: float
    diameter: float
    widths: np.ndarray | None = None

    def of(self, points: np.ndarray) -> Fibre:
        """Return the fibres of strands whose points are in the groom at places, (s, n+1) int, or (P,)."""
        given = (self.axial, self.bending, self.torsion, self.line_density)
        over = [v[:, points] if isinstance(v, np.ndarray) else np.broadcast_to(v, (2, *points.shape)) for v in given]
        on_segments = (values[1, ..., :-1] for values in over)
        return Fibre(Section(*(v[0] for v in over), self.softening), Section(*on_segments, self.softening))


def fibres_of(groom: Groom, material: Material | VariedMaterial, read_image: ReadImage | None = None) -> Fibres:
    """Return the fibres of a groom; BadInput as `values_of`."""
    fibre = RoundFibre()
    for field in fields(material):
        of = values_of(getattr(material, field.name), groom, f"material.{field.name}", read_image)
        setattr(fibre, field.name, of)
    found = Fibres(fibre.axial, fibre.bending, fibre.torsion, fibre.line_density, fibre.softening, fibre.diameter)
    if np.ndim(fibre.diameter) == 0:
        return found
    widths = fibre.diameter[0]
    return found._replace(diameter=float(np.mean(widths)), widths=widths.astype(np.float32))
