"""Hair pinned to a body: ties, clips, props."""

from typing import TYPE_CHECKING, Annotated

from hairpipe.engine import node
from hairpipe.units import Fraction, Gt, Hertz, Interval, Metres
from hairpipe.values import Groom, Mesh, Pins

if TYPE_CHECKING:
    from hairpipe.shot.goals import Pinned

Place = tuple[Metres, Metres, Metres]


def bind(
    groom: Groom, rest: Mesh | None, group: str | None, at: tuple[Fraction, ...], place: Place | None, reach: float
) -> "Pinned":
    """Bind the pinned points to the body at rest, for the whole shot."""
    from hairpipe.shot.goals import pin

    return pin(groom, rest, group, at, place, reach)


@node(frames="each", prepare=bind)
def pin_hair(
    groom: Groom,
    rest: Mesh | None,
    body: Mesh,
    prepared: "Pinned",
    *,
    group: str | None = None,
    at: tuple[Fraction, ...] = (),
    place: Place | None = None,
    reach: Annotated[Metres, Gt(0.0)] = 0.05,
    frequency: Annotated[Hertz, Interval(gt=0.0, le=1e4)] = 200.0,
    damping: Annotated[float, Interval(ge=0.0, le=100.0)] = 1.0,
) -> Pins:
    """Pull points of strands to a body that carries them: a hair tie on the skin, a clip, a hand.

    With the body at rest as `rest`, every pinned point keeps its place relative to the closest place of the body, which
    may be any body. Without it the body is the skin, and pinned points move rigidly with the roots of their strands.

    group      name of the group of the groom that is pinned; by default all strands
    at         positions of pins along a strand, as fractions of its length from the root: the nearest points
    place      position of a hair tie at rest, which pins the nearest point of each strand; without `at` and `place` it
               is the point nearest to `rest`
    reach      maximum distance of pinned points from `rest`
    frequency  natural frequency of a free point about its place: the higher, the harder the pin
    damping    ratio of damping to critical damping, for motion relative to the body
    """
    from hairpipe.shot.goals import check_mesh
    from hairpipe.solve.boundary import motion_of_sites

    check_mesh(prepared, body)
    motions, rates = motion_of_sites(body, *prepared.sites, prepared.frames)
    places, velocities = (
        (moves[:, :, :3] @ prepared.rest[:, :, None])[:, :, 0] + moves[:, :, 3] for moves in (motions, rates)
    )
    return Pins(prepared.points, places, velocities, frequency, damping, len(groom.points))
