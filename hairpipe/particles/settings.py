"""What a shot says about hair of particles, in physical terms."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, Literal

from hairpipe.sim.air.wind import Wind
from hairpipe.sim.settings import Air
from hairpipe.units import (
    Ge,
    Gt,
    Interval,
    KilogramsPerCubicMetre,
    Metres,
    MetresPerSecondSquared,
    MetresSquaredPerSecondSquared,
    PerSecond,
)


@dataclass(frozen=True)
class Fibre:
    """What the hair consists of that particles stand for.

    diameter  of the fibre
    density   of the fibre
    """

    diameter: Annotated[Metres, Interval(ge=1e-5, le=2e-3)] = 80e-6
    density: Annotated[KilogramsPerCubicMetre, Interval(ge=10.0, le=1e4)] = 1310.0

    @property
    def line_density(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * pi * self.diameter**2 / 4


@dataclass(frozen=True)
class Interaction:
    """Hair that acts on hair, (16) to (18). Rates are those of particles in the same place.

    pressure   over the density that is too much, k_a: hair denser than at rest spreads
    collision  rate at which particles that approach lose their speed across the hair
    friction   rate at which they lose what slides
    bound      friction is at most so many times what presses them together, after Coulomb
    """

    pressure: Annotated[MetresSquaredPerSecondSquared, Ge(0.0)] = 1.0
    collision: Annotated[PerSecond, Ge(0.0)] = 50.0
    friction: Annotated[PerSecond, Ge(0.0)] = 50.0
    bound: Annotated[float, Ge(0.0)] = 0.3


@dataclass(frozen=True)
class ParticleContact:
    """How particles touch bodies.

    friction   Coulomb coefficient
    thickness  distance kept from the surface; a particle that is nearer to its root along the hair keeps half of that
    """

    friction: Annotated[float, Ge(0.0)] = 0.4
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 3e-3


@dataclass(frozen=True)
class RestTension:
    """Links that carry the hair as groomed: they are shorter than they are there.

    strain  of a link by which it may be shorter; what would need more sags
    """

    strain: Annotated[float, Interval(gt=0.0, le=0.9)] = 0.3


Printed = Literal["steps", "pressure", "friction", "links"]
"""Equations that can be had as the paper prints them, where hair fails by them; `ParticleSettings` says how."""


@dataclass(frozen=True)
class ParticleSettings:
    """All that a graph says of the simulation of particles.

    sag          by which hair of mean length that hangs is stretched at its root; all stiffness follows from it
    damping      of a link, a fraction of critical damping
    steps        in a frame; one is faster, and damps swings more
    gravity      along -Y
    air          what slows hair
    fibre        that hair consists of; wind takes hold of it
    contact      how it touches bodies, whole level sets and those in parts; without any it passes through
    interaction  hair acts on hair; without, it passes through
    sag_free     links carry the hair as groomed; without, they rest in the groom's shape and hair sags from it
    wind         moving air, which takes the place of `air`; without, it is still
    printed      what is to be as the paper prints it, to see how it fails: explicit `steps`, (16) `pressure` with one
                 density at rest, which attracts, (18) `friction` without bound, `links` that fade, all of them
    """

    sag: Annotated[float, Interval(gt=1e-3, le=1.0)] = 0.1
    damping: Annotated[float, Ge(0.0)] = 0.2
    steps: Annotated[int, Interval(ge=1, le=100)] = 2
    gravity: Annotated[MetresPerSecondSquared, Gt(0.0), Interval(le=1000.0)] = 9.81
    air: Air = Air(3.0)  # noqa: RUF009 (frozen)
    fibre: Fibre = Fibre()
    contact: ParticleContact = ParticleContact()
    interaction: Interaction | None = None
    sag_free: RestTension | None = None
    wind: Wind | None = None
    printed: tuple[Printed, ...] = ()
