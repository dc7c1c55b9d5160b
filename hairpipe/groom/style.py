"""Settings of grow_groom."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.groom.painting import Painted, PaintedDegrees, PaintedMetres
from hairpipe.units import Ge, Gt, Metres


@dataclass(frozen=True)
class Comb:
    """Pulls on hair that lies on the body, in units of gravity, in addition to gravity.

    parting   distance of the parting from the middle of the face, to the left
    sideways  strength of the pull away from the parting, on the front half of the head
    back      strength of the pull away from the face
    stray     strength of a pull in a random direction for each strand
    """

    parting: Metres = 0.0
    sideways: Painted = Painted(1.2)  # noqa: RUF009 (frozen)
    back: Painted = Painted(1.0)  # noqa: RUF009 (frozen)
    stray: Annotated[float, Ge(0.0)] = 0.15


@dataclass(frozen=True)
class Curl:
    """Helix around the path of straight hair, of the same arc length.

    radius  radius of the helix; strands with a painted radius or pitch of 0 are straight
    pitch   advance of the helix along its axis per turn
    onset   length from the root over which the radius grows from zero
    """

    radius: PaintedMetres = PaintedMetres(0.006)  # noqa: RUF009 (frozen)
    pitch: PaintedMetres = PaintedMetres(0.03)  # noqa: RUF009 (frozen)
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

    length: PaintedMetres = PaintedMetres(0.25)  # noqa: RUF009 (frozen)
    lift: PaintedDegrees = PaintedDegrees(30.0)  # noqa: RUF009 (frozen)
    bend: Annotated[Metres, Gt(0.0)] = 0.03
    volume: Annotated[Metres, Ge(0.0)] = 0.012
    comb: Comb = Comb()
    curl: Curl | None = None
