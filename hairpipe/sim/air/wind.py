"""Settings of the wind of a shot, in physical units."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.units import Ge, Gt, Interval, KilogramsPerCubicMetre, Metres, MetresPerSecond, PascalSeconds, Seconds

Velocity = tuple[MetresPerSecond, MetresPerSecond, MetresPerSecond]


@dataclass(frozen=True)
class Coefficients:
    """Drag in proportion to speed: the force on a metre of hair at 1 m/s.

    normal      of air that comes from the side
    tangential  of air along the hair
    """

    normal: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 2e-4
    tangential: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 5e-5


@dataclass(frozen=True)
class Gusts:
    """Eddies that the wind carries along.

    strength  root mean square of each component of their velocity
    size      over which they differ: their correlation along a line falls as exp(-(r / size)^2 / 2)
    duration  over which an eddy that is followed changes: its correlation falls as exp(-(t / duration)^2 / 2)
    seed      another number, other gusts
    """

    strength: Annotated[MetresPerSecond, Interval(ge=0.0, le=100.0)] = 1.0
    size: Annotated[Metres, Interval(gt=1e-3, le=1e3)] = 0.5
    duration: Annotated[Seconds, Interval(gt=1e-3, le=1e4)] = 0.5
    seed: Annotated[int, Ge(0)] = 0


@dataclass(frozen=True)
class Shielding:
    """Hair keeps the wind from the hair behind it.

    cell   of the grid on which hair is counted; coarser where hair is spread so far that the grid would be huge
    hairs  that a strand stands for where it shields
    """

    cell: Annotated[Metres, Interval(ge=1e-3, le=1.0)] = 0.01
    hairs: Annotated[float, Interval(ge=0.0, le=1e6)] = 1.0


@dataclass(frozen=True)
class Wind:
    """Moving air, and the drag of a fibre in it; it takes the place of `air.drag`, which is the same for still air.

    velocity      of the air on the mean; zeros for the drag of still air
    density       of the air
    viscosity     of the air
    coefficients  of drag that the shot prescribes, instead of those of a cylinder at its Reynolds number
    gusts         steady wind without
    shielding     the same wind everywhere without
    """

    velocity: Velocity = (0.0, 0.0, -1.0)
    density: Annotated[KilogramsPerCubicMetre, Gt(0.0)] = 1.2
    viscosity: Annotated[PascalSeconds, Gt(0.0)] = 1.8e-5
    coefficients: Coefficients | None = None
    gusts: Gusts | None = None
    shielding: Shielding | None = None
