"""Settings of the shape goal, in physical units."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.groom.grow.style import Profile
from hairpipe.units import Hertz, Interval


@dataclass(frozen=True)
class Goal:
    """Pull of every point of hair to its place in the groom, which the skin carries rigidly.

    frequency  natural frequency of a free point about its place
    damping    ratio of damping to critical damping, for motion relative to that place
    profile    factor of the frequency along the hair: fractions of the length from the root, ascending, each with its
               factor, linear between them; by default 1
    groups     names of the groups of the groom that are pulled; by default all
    """

    frequency: Annotated[Hertz, Interval(ge=0.0, le=1e4)] = 4.0
    damping: Annotated[float, Interval(ge=0.0, le=100.0)] = 1.0
    profile: Profile = ()
    groups: tuple[str, ...] = ()
