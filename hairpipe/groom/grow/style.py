"""How hair grows: the settings of grow_groom, and what in them can be painted."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from hairpipe.units import Degrees, Fraction, Ge, Gt, Interval, Metres


@dataclass(frozen=True)
class Paint:
    """Values 0..1 painted on the body, as a vertex map or as an image over its texture coordinates.

    map    name of a vertex map of the body
    image  file of a picture, black is 0 and white is 1
    """

    map: str | None = None
    image: Path | None = None


@dataclass(frozen=True)
class Painted:
    """A number for every strand, which the graph file gives as such or as a table.

    value      where the paint is 1, and everywhere when nothing is painted
    low        where the paint is 0
    variation  relative: every strand has a factor of its own within 1 - variation and 1 + variation
    map        name of a vertex map of the body that paints it
    image      file of a picture that paints it, black is 0 and white is 1
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


@dataclass(frozen=True)
class Comb:
    """Where hair that lies on the body is pulled, in units of gravity, which pulls it down.

    parting   where it parts, to the left of the middle of the face
    sideways  away from the parting, on the front half of the head
    back      away from the face
    stray     strength of a pull of its own, in any direction, that every strand has besides
    """

    parting: Metres = 0.0
    sideways: Painted = Painted(1.2)
    back: Painted = Painted(1.0)
    stray: Annotated[float, Ge(0.0)] = 0.15


@dataclass(frozen=True)
class Curl:
    """Curly hair: a helix around the way that straight hair would take; its length is that of the hair, uncurled.

    radius  of the helix; where it or the pitch is painted 0 hair is straight
    pitch   of the helix, along its axis for one turn
    onset   from the root, over which the radius grows from nothing
    """

    radius: PaintedMetres = PaintedMetres(0.006)
    pitch: PaintedMetres = PaintedMetres(0.03)
    onset: Annotated[Metres, Gt(0.0)] = 0.04


@dataclass(frozen=True)
class Style:
    """How hair grows.

    length  along the hair, from root to tip
    lift    between the skin and the hair that leaves it
    bend    length over which hair turns from there to where it is pulled
    volume  thickness of the hair lying on the body, each strand in a layer of its own
    comb    where hair lying on the body is pulled
    curl    curly hair; without it hair is straight
    """

    length: PaintedMetres = PaintedMetres(0.25)
    lift: PaintedDegrees = PaintedDegrees(30.0)
    bend: Annotated[Metres, Gt(0.0)] = 0.03
    volume: Annotated[Metres, Ge(0.0)] = 0.012
    comb: Comb = Comb()
    curl: Curl | None = None
