"""Settings of a simulation of particles, in physical units."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, Literal

from hairpipe.laws.settings import Wind
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
class Air:
    """Still air.

    drag  damping rate of the velocity
    """

    drag: Annotated[PerSecond, Interval(ge=0.0, le=1000.0)] = 3.0


@dataclass(frozen=True)
class Fibre:
    """The fibres that particles represent.

    diameter  diameter of the fibre
    density   mass density of the fibre
    """

    diameter: Annotated[Metres, Interval(ge=1e-5, le=2e-3)] = 80e-6
    density: Annotated[KilogramsPerCubicMetre, Interval(ge=10.0, le=1e4)] = 1310.0

    @property
    def line_density(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * pi * self.diameter**2 / 4


@dataclass(frozen=True)
class Interaction:
    """Forces between particles of hair, (16) to (18). Rates hold for coincident particles.

    pressure   pressure per excess density, k_a: hair denser than at rest spreads
    collision  damping rate of the approach of particles, across the hair
    friction   damping rate of the sliding of particles
    bound      maximum ratio of friction to normal force (Coulomb)
    """

    pressure: Annotated[MetresSquaredPerSecondSquared, Ge(0.0)] = 1.0
    collision: Annotated[PerSecond, Ge(0.0)] = 50.0
    friction: Annotated[PerSecond, Ge(0.0)] = 50.0
    bound: Annotated[float, Ge(0.0)] = 0.3


@dataclass(frozen=True)
class ParticleContact:
    """Contact of particles with bodies.

    friction   Coulomb friction coefficient between hair and bodies
    thickness  distance kept from the surface; within this arc length of the root, half of it
    """

    friction: Annotated[float, Ge(0.0)] = 0.4
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 3e-3


@dataclass(frozen=True)
class RestTension:
    """Pre-tension of links: their rest lengths are shorter than their lengths in the groom.

    strain  maximum strain of a link at rest; hair that needs more sags
    """

    strain: Annotated[float, Interval(gt=0.0, le=0.9)] = 0.3


Printed = Literal["steps", "pressure", "friction", "links"]
"""Formulas available as published, for comparison; `ParticleSettings` describes them."""


@dataclass(frozen=True)
class ParticleSettings:
    """All settings of the simulation of particles.

    sag          strain at the root of hanging hair of mean length; determines all stiffness
    damping      damping of links, as a fraction of critical damping
    steps        number of steps per frame; one is faster and damps swings more
    gravity      gravitational acceleration along -Y
    air          drag of still air
    fibre        fibres that particles represent, on which wind acts
    contact      contact with bodies, whole level sets and parts; if absent, hair passes through bodies
    interaction  forces between particles of hair; if absent, there are none
    sag_free     equilibrium of the groom at the start, by pre-tension of links; if absent, hair sags from it
    wind         moving air, in place of `air`; if absent, air is still
    printed      published formulas to use for comparison: explicit `steps`, (16) `pressure` with one rest density
                 (attracts), (18) `friction` without bound, fading `links`
    """

    sag: Annotated[float, Interval(gt=1e-3, le=1.0)] = 0.1
    damping: Annotated[float, Ge(0.0)] = 0.2
    steps: Annotated[int, Interval(ge=1, le=100)] = 2
    gravity: Annotated[MetresPerSecondSquared, Gt(0.0), Interval(le=1000.0)] = 9.81
    air: Air = Air()
    fibre: Fibre = Fibre()
    contact: ParticleContact = ParticleContact()
    interaction: Interaction | None = None
    sag_free: RestTension | None = None
    wind: Wind | None = None
    printed: tuple[Printed, ...] = ()
