"""Settings that are painted on a body, and settings that vary from strand to strand and along strands."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from hairpipe.groom.painting.tiles import MARK, list_tiles
from hairpipe.units import Degrees, Fraction, Ge, Gt, Interval, Metres, Reads

Image = Annotated[Path, Reads(list_tiles, MARK)]
"""A picture, or its tiles."""


@dataclass(frozen=True)
class Paint:
    """Values 0..1 painted on the body, as a vertex map or as an image over its texture coordinates.

    map    name of a vertex map of the body
    image  path of an image file, or of tiles, name.<UDIM>.png: black is 0, white is 1
    """

    map: str | None = None
    image: Image | None = None


@dataclass(frozen=True)
class Painted:
    """A number per strand, given as a plain number or as a table.

    value      value at a paint of 1, or everywhere without paint
    low        value at a paint of 0
    variation  relative variation: each strand has a random factor in [1 - variation, 1 + variation]
    map        name of a vertex map of the body that scales the value
    image      path of an image file, or of tiles, name.<UDIM>.png, that scales the value: black is 0, white is 1
    """

    value: float
    low: float = 0.0
    variation: Fraction = 0.0
    map: str | None = None
    image: Image | None = None


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
    image      path of an image file, or of tiles, name.<UDIM>.png, over the texture coordinates of roots, that scales
               the value: black is 0, white is 1
    profile    factors along a strand: fractions of the length from the root, ascending, each with its factor, linear
               between them, and equal beyond the first and last; by default 1
    groups     factors of groups of the groom, each ["name", factor]; 1 for others
    """

    profile: Profile = ()
    groups: tuple[tuple[str, Factor], ...] = ()

    @property
    def is_constant(self) -> bool:
        """Whether the setting is its value everywhere."""
        return self == type(self)(self.value)


@dataclass(frozen=True)
class VariedWidth(Varied):
    """A width of strands; the widths that the groom carries can take the place of its value.

    widths  factor on the widths of the groom, which then take the place of `value`; by default they are not used
    """

    widths: Factor | None = None
