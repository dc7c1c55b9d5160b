"""The ends of strands at a time, as tracks and waves move them."""

import numpy as np

from hairpipe.data import Ends, Groom
from hairpipe.scripted_ends.rigid_paths import Motion, after, turned, unit
from hairpipe.scripted_ends.track import INSTANT, Track, course_of
from hairpipe.scripted_ends.wave import Wave, course_of_wave


def drive(
    groom: Groom, time: float, roots: Track, wave: Wave | None, tips: Track | None, release: float | None
) -> Ends:
    """Return the ends at a time [s].

    roots    motion of the roots, and the wave in the frame that it moves
    tips     motion of the tips; free without
    release  time after which the tips are free [s]
    """
    first = groom.points[groom.offsets[:-1]]
    last = groom.points[groom.offsets[1:] - 1]
    root = follow(roots, first, time)
    if wave:
        course = course_of_wave(wave, time)
        root = after(root, turned(course, unit(wave.axis, "axis"), first + np.array(wave.pivot)))
    held = tips if release is None or time <= release + 3.0 * INSTANT else None
    tip = Motion(*np.full((2, *root.place.shape), np.nan)) if held is None else follow(held, last, time)
    return Ends(root.place, root.rate, tip.place, tip.rate)


def follow(track: Track, ends: np.ndarray, time: float) -> Motion:
    """Move ends, (S, 3) [m], along a track."""
    return turned(course_of(track, time), unit(track.axis, "axis"), ends + np.array(track.pivot))
