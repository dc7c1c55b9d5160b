"""Where a body of springs is put, and how its time is cut."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.units import Ge, Interval, MetresPerSecond, MetresPerSecondSquared, PerSecond, Seconds

Scheme = Literal["tr_bdf2", "backward_euler"]


@dataclass(frozen=True)
class Ground:
    """Level ground at y = 0.

    friction  Coulomb friction coefficient of the ground
    """

    friction: Annotated[float, Interval(ge=0.0, le=100.0)] = 0.5


@dataclass(frozen=True)
class Stir:
    """Random initial velocity of each particle.

    speed  standard deviation of the velocity along each axis
    seed   seed of the random numbers
    """

    speed: Annotated[MetresPerSecond, Interval(ge=0.0, le=100.0)] = 0.3
    seed: Annotated[int, Ge(0)] = 0


@dataclass(frozen=True)
class ElasticScene:
    """Forces and time integration of shells and solids.

    gravity  gravitational acceleration along -Y
    drag     damping rate of the velocity in still air
    ground   level ground at y = 0; if absent, bodies fall freely
    stir     random initial velocities; if absent, bodies start at rest
    slack    time at which springs begin to act
    steps    number of equal steps per frame
    scheme   time integrator: tr_bdf2 (second order), or backward_euler (first order, damps)
    """

    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81
    drag: Annotated[PerSecond, Interval(ge=0.0, le=1000.0)] = 0.0
    slack: Annotated[Seconds, Interval(ge=0.0, le=1e6)] = 0.0
    steps: Annotated[int, Interval(ge=1, le=100_000)] = 10
    scheme: Scheme = "tr_bdf2"
    ground: Ground | None = None
    stir: Stir | None = None
