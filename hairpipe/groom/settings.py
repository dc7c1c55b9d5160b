"""Settings of grown hair and of tufts; no kernel is compiled."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.units import Degrees, Ge, Gt, Interval, Metres
from hairpipe.values.painting import Painted, PaintedDegrees, PaintedMetres


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
