"""Scripted motion of the ends of hair."""

from typing import Annotated

from hairpipe.body.scripted_motion import Track, Wave
from hairpipe.engine import Cuts, Time, node
from hairpipe.units import Ge, Seconds
from hairpipe.values import Ends, Groom


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
    """Move the ends of all strands along keys or waves, with exact velocities; without these, roots are fixed.

    at       frame of the shot at time zero of the keys
    roots    motion of the roots by keys; if absent, roots are fixed
    wave     oscillation of the roots, added to their keys
    tips     motion of the tips by keys; if absent, tips are free; {} fixes them
    release  time of release of the tips, at the last frame not after it; if absent, tips stay held
    """
    from hairpipe.body.scripted_motion import drive, instant_of

    return drive(groom, instant_of(time.frame, at, time.fps, cuts), roots, wave, tips, release)
