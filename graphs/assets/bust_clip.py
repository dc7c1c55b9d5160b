"""Joints of the bust, and start and end of a movement, for the clips shipped here."""

import numpy as np

from hairpipe.body.bust import CROWN, JOINTS
from hairpipe.values.body import Clip

ROTATIONS = ("Yrotation", "Xrotation", "Zrotation")


def bust_clip(sway: np.ndarray, turns: list[np.ndarray], rate: float) -> Clip:
    """Return a clip of the bust, in metres.

    sway   (n, 3) of the first joint from its place at rest [m]
    turns  of each joint from the first: yaw, nod and roll (n, 3) [deg]
    rate   samples a second
    """
    places = np.array(list(JOINTS.values()))
    ends = np.full_like(places, np.nan)
    ends[-1] = np.array(CROWN) - places[-1]
    return Clip(
        names=tuple(JOINTS),
        parents=np.arange(-1, len(JOINTS) - 1, dtype=np.int32),
        offsets=np.concatenate([places[:1], np.diff(places, axis=0)]),
        ends=ends,
        channels=(("Xposition", "Yposition", "Zposition", *ROTATIONS), *[ROTATIONS] * (len(JOINTS) - 1)),
        values=np.concatenate([places[0] + sway, *turns], axis=1),
        frame_time=1.0 / rate,
    )


def rise(time: np.ndarray, first: float, last: float) -> np.ndarray:
    """Return the step 6s^5 - 15s^4 + 10s^3 from 0 at `first` to 1 at `last`: no jump in the acceleration."""
    share = np.clip((time - first) / (last - first), 0.0, 1.0)
    return share**3 * (share * (6.0 * share - 15.0) + 10.0)
