"""Hands that hold the ends of hair."""

from typing import Annotated

from hairpipe.data import Ends, Groom
from hairpipe.graph import Cuts, Time, node
from hairpipe.scripted_ends.track import Track
from hairpipe.scripted_ends.wave import Wave
from hairpipe.units import Ge, Seconds


@node(frames="each")
def drive_ends(
    groom: Groom,
    time: Time,
    cuts: Cuts,
    *,
    at: int = 1001,
    roots: Track = Track(),  # noqa: B008 (frozen)
    wave: Wave | None = None,
    tips: Track | None = None,
    release: Annotated[Seconds, Ge(0.0)] | None = None,
) -> Ends:
    """The ends of all strands at a frame, led along keys or waves with exact velocities; without, roots stand still.

    at       frame of the shot at which time is zero
    roots    motion of the roots by keys
    wave     oscillation that is added to the motion of the roots
    tips     motion of the tips by keys; without it they are free, with {} they stand still
    release  of the tips, at the last frame that is not after this time; never without
    """
    from hairpipe.scripted_ends.ends import lead
    from hairpipe.scripted_ends.track import instant_of

    return lead(groom, instant_of(time.frame, at, time.fps, cuts), roots, wave, tips, release)
