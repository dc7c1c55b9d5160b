"""Settings that are painted on a body, or vary from strand to strand and along strands; no kernel is compiled."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.units import Degrees, Fraction, Ge, Gt, Interval, Metres, Reads

MARK = "<UDIM>"


def list_tiles(path: Path) -> dict[str, Path]:
    """Return the files of an image by the numbers of the tiles; one alone has none. BadInput where there are none."""
    before, mark, after = path.name.partition(MARK)
    if not mark:
        return {"": path}
    form = re.compile(rf"{re.escape(before)}([1-9]\d{{3}}){re.escape(after)}")
    try:
        names = sorted(file.name for file in path.parent.iterdir())
    except OSError:
        names = []
    found = {match[1]: path.with_name(name) for name in names if (match := form.fullmatch(name))}
    if not found:
        raise BadInput("there are no tiles", where=path, right=path.name.replace(MARK, str(FIRST)))
    return found


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


ReadImage = Callable[[Path], np.ndarray]


"""Returns the image in a file, (height, width) float64 in 0..1, the top row first."""


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


FIRST = 1001


SHORTEST = 0.001


"""Segment that hair of common material bears [m]: 80 um, softened by 100, is a rod down to 0.63 mm."""


@dataclass(frozen=True)
class Tuft:
    """Further rows of strands, and random directions of strands.

    rows   number of rows of strands
    apart  distance from one row to the next
    stray  root mean square angle between strands and the common direction
    seed   seed of the random numbers
    """

    rows: Annotated[int, Interval(ge=1, le=10_000)] = 1
    apart: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.01)
    stray: Annotated[Degrees, Interval(ge=0.0, le=90.0)] = 0.0
    seed: Annotated[int, Ge(0)] = 0
