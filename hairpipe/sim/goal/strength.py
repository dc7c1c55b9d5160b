"""Settings of the shape goal, in physical units."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.groom.painting.painted import Varied
from hairpipe.units import Hertz, Interval

FREQUENCIES = Interval(ge=0.0, le=1e4)


@dataclass(frozen=True)
class Frequency(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[Hertz, FREQUENCIES]
    low: Annotated[Hertz, FREQUENCIES] = 0.0


@dataclass(frozen=True)
class Goal:
    """Pull of every point of hair to its place in the groom, which the skin carries rigidly.

    frequency  natural frequency of a free point about its place; 0 where there is no pull
    damping    ratio of damping to critical damping, for motion relative to that place
    """

    frequency: Frequency = Frequency(4.0)
    damping: Annotated[float, Interval(ge=0.0, le=100.0)] = 1.0
