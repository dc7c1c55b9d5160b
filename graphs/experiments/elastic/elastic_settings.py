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
    """What a body of springs moves in, and how that is computed.

    gravity  along -Y
    drag     rate at which still air takes away speed
    ground   it falls on; without one it falls for ever
    stir     random velocities to start with
    slack    time before which no spring acts
    steps    of equal length in a frame
    scheme   tr_bdf2 of second order, or backward_euler, which damps
    """

    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81
    drag: Annotated[PerSecond, Interval(ge=0.0, le=1000.0)] = 0.0
    slack: Annotated[Seconds, Interval(ge=0.0, le=1e6)] = 0.0
    steps: Annotated[int, Interval(ge=1, le=100_000)] = 10
    scheme: Scheme = "tr_bdf2"
    ground: Ground | None = None
    stir: Stir | None = None
