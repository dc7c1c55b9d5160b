"""Settings of grow_groom, and settings that are painted on a body or vary along hair."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from hairpipe.units import Degrees, Fraction, Ge, Gt, Interval, Metres


@dataclass(frozen=True)
class Paint:
    """Values 0..1 painted on the body, as a vertex map or as an image over its texture coordinates.

    map    name of a vertex map of the body
    image  path of an image file: black is 0, white is 1
    """

    map: str | None = None
    image: Path | None = None


@dataclass(frozen=True)
class Painted:
    """A number per strand, given as a plain number or as a table.

    value      value at a paint of 1, or everywhere without paint
    low        value at a paint of 0
    variation  relative variation: each strand has a random factor in [1 - variation, 1 + variation]
    map        name of a vertex map of the body that scales the value
    image      path of an image file that scales the value: black is 0, white is 1
    """

    value: float
    low: float = 0.0
    variation: Fraction = 0.0
    map: str | None = None
    image: Path | None = None


@dataclass(frozen=True)
class PaintedMetres(Painted):
    __doc__ = Painted.__doc__
    value: Annotated[Metres, Gt(0.0)]
    low: Annotated[Metres, Ge(0.0)] = 0.0


@dataclass(frozen=True)
class PaintedDegrees(Painted):
    __doc__ = Painted.__doc__
    value: Annotated[Degrees, Interval(ge=0.0, le=90.0)]
    low: Annotated[Degrees, Interval(ge=0.0, le=90.0)] = 0.0


Factor = Annotated[float, Ge(0.0)]
Profile = tuple[tuple[Fraction, Factor], ...]
"""Fractions of the length of a strand from the root, ascending, each with its factor; linear between them."""


@dataclass(frozen=True)
class Varied(Painted):
    """A number that varies from strand to strand and along strands, given as a plain number or as a table.

    value      value at a map of 1, or everywhere without map
    low        value at a map of 0
    variation  relative variation: each strand has a random factor in [1 - variation, 1 + variation]
    map        name of a map of the groom that scales the value: a vertex map of its scalp, a primvar of its file, or a
               group, which is 1 on its strands and 0 on others
    image      path of an image file, over the texture coordinates of roots, that scales the value: black is 0, white
               is 1
    profile    factors along a strand: fractions of the length from the root, ascending, each with its factor, linear
               between them, and equal beyond the first and last; by default 1
    groups     factors of groups of the groom, each ["name", factor]; 1 for others
    """

    profile: Profile = ()
    groups: tuple[tuple[str, Factor], ...] = ()


@dataclass(frozen=True)
class VariedWidth(Varied):
    """A width of strands; the widths that the groom carries can take the place of its value.

    widths  factor on the widths of the groom, which then take the place of `value`; by default they are not used
    """

    widths: Factor | None = None


@dataclass(frozen=True)
class Comb:
    """Pulls on hair that lies on the body, in units of gravity, in addition to gravity.

    parting   distance of the parting from the middle of the face, to the left
    sideways  strength of the pull away from the parting, on the front half of the head
    back      strength of the pull away from the face
    stray     strength of a pull in a random direction for each strand
    """

    parting: Metres = 0.0
    sideways: Painted = Painted(1.2)
    back: Painted = Painted(1.0)
    stray: Annotated[float, Ge(0.0)] = 0.15


@dataclass(frozen=True)
class Curl:
    """Helix around the path of straight hair, of the same arc length.

    radius  radius of the helix; strands with a painted radius or pitch of 0 are straight
    pitch   advance of the helix along its axis per turn
    onset   length from the root over which the radius grows from zero
    """

    radius: PaintedMetres = PaintedMetres(0.006)
    pitch: PaintedMetres = PaintedMetres(0.03)
    onset: Annotated[Metres, Gt(0.0)] = 0.04


@dataclass(frozen=True)
class Style:
    """Shape of grown hair.

    length  length of a strand from root to tip
    lift    angle between the skin and a strand at its root
    bend    length over which a strand bends from the angle of lift to the combed direction
    volume  thickness of hair that lies on the body, each strand in its own layer
    comb    pull on hair that lies on the body
    curl    helix around the path of each strand; if absent, hair is straight
    """

    length: PaintedMetres = PaintedMetres(0.25)
    lift: PaintedDegrees = PaintedDegrees(30.0)
    bend: Annotated[Metres, Gt(0.0)] = 0.03
    volume: Annotated[Metres, Ge(0.0)] = 0.012
    comb: Comb = Comb()
    curl: Curl | None = None
