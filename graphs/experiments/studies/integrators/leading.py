"""Initial strands of a trial, and the prescribed motion of their ends."""

import numpy as np

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.graphs.experiments.studies.integrators.trial import MOTIONS, Strand
from hairpipe.groom.strands import lay_strands, unbound
from hairpipe.values import Ends, Groom


def groom_of(strands: list[Strand], segments: int) -> Groom:
    """Lay strands as they start, all roots in one place: nothing touches them."""
    points, frames = [], []
    for strand in strands:
        angle = np.radians(MOTIONS[strand.motion].from_hanging)
        direction = float(np.sin(angle)), -float(np.cos(angle)), 0.0
        one = lay_strands(1, strand.length, segments, direction, (0.0, 0.0, 0.0), None, 0.0)
        points.append(one.points)
        frames.append(one.root_frames)
    return unbound(np.stack(points), np.concatenate(frames))


def ends_at(strands: list[Strand], groom: Groom, time: float) -> Ends:
    """Find where the ends of strands are led at a time [s]; tips are free."""
    driven = {strand.motion: drive(groom, time, Track(), MOTIONS[strand.motion].wave, None, None) for strand in strands}
    mine = [(driven[strand.motion], n) for n, strand in enumerate(strands)]
    return Ends(
        np.stack([ends.roots[n] for ends, n in mine]),
        np.stack([ends.roots_rate[n] for ends, n in mine]),
        np.stack([ends.tips[n] for ends, n in mine]),
        np.stack([ends.tips_rate[n] for ends, n in mine]),
    )
