"""Settings of the wind of a shot, in physical units."""

from dataclasses import dataclass
from math import hypot
from typing import Annotated
from warnings import warn

from hairpipe.units import Ge, Gt, Interval, KilogramsPerCubicMetre, Metres, MetresPerSecond, PascalSeconds, Seconds

STORM = 115.0
"""Speed of the strongest gust that was measured near the ground, in 1996, rounded up [m/s]."""
Velocity = tuple[MetresPerSecond, MetresPerSecond, MetresPerSecond]


@dataclass(frozen=True)
class Coefficients:
    """Linear drag: force on a metre of hair at 1 m/s.

    normal      drag coefficient of flow across the hair
    tangential  drag coefficient of flow along the hair
    """

    normal: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 2e-4
    tangential: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 5e-5


@dataclass(frozen=True)
class Gusts:
    """Turbulent eddies, advected by the wind.

    strength  root mean square of each component of the velocity
    size      correlation length: the correlation along a line is exp(-(r / size)^2 / 2)
    duration  correlation time in the moving frame: the correlation is exp(-(t / duration)^2 / 2)
    seed      seed of the random numbers
    """

    strength: Annotated[MetresPerSecond, Interval(ge=0.0, le=100.0)] = 1.0
    size: Annotated[Metres, Interval(gt=1e-3, le=1e3)] = 0.5
    duration: Annotated[Seconds, Interval(gt=1e-3, le=1e4)] = 0.5
    seed: Annotated[int, Ge(0)] = 0


@dataclass(frozen=True)
class Shielding:
    """Reduction of the wind by hair upstream.

    cell   cell size of the grid of hair density; larger for a very wide groom
    hairs  number of hairs that a strand represents in the density
    """

    cell: Annotated[Metres, Interval(ge=1e-3, le=1.0)] = 0.01
    hairs: Annotated[float, Interval(ge=0.0, le=1e6)] = 1.0


@dataclass(frozen=True)
class Wind:
    """Moving air and the drag of a fibre in it, in place of `air.drag` for still air.

    velocity      mean velocity of the air; zero for the drag of still air
    density       mass density of the air
    viscosity     dynamic viscosity of the air
    coefficients  prescribed drag coefficients, in place of those of a cylinder at its Reynolds number
    gusts         turbulence of the wind; if absent, the wind is steady
    shielding     reduction of the wind by hair upstream; if absent, the wind is uniform
    """

    velocity: Velocity = (0.0, 0.0, -1.0)
    density: Annotated[KilogramsPerCubicMetre, Gt(0.0)] = 1.2
    viscosity: Annotated[PascalSeconds, Gt(0.0)] = 1.8e-5
    coefficients: Coefficients | None = None
    gusts: Gusts | None = None
    shielding: Shielding | None = None


def warn_of_storm(wind: Wind | None) -> None:
    """Warn of a mean velocity above that of any storm."""
    speed = 0.0 if wind is None else hypot(*wind.velocity)
    if speed > STORM:
        message = f"wind.velocity has {speed:,.0f} m/s, above {STORM:.0f} m/s, the strongest gust ever measured"
        warn(f"{message} (velocities are in m/s)", stacklevel=3)
