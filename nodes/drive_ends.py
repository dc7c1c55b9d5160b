"""Scripted motion of the ends of hair."""

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
    """Move the ends of all strands along keys or waves, with exact velocities; without these, roots are fixed.

    at       frame of the shot at time zero of the keys
    roots    motion of the roots by keys; if absent, roots are fixed
    wave     oscillation of the roots, added to their keys
    tips     motion of the tips by keys; if absent, tips are free; {} fixes them
    release  time of release of the tips, at the last frame not after it; if absent, tips stay held
    """
    from hairpipe.scripted_ends.ends import drive
    from hairpipe.scripted_ends.track import instant_of

    return drive(groom, instant_of(time.frame, at, time.fps, cuts), roots, wave, tips, release)
