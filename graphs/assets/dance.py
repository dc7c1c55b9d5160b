"""Generated motion: ten vigorous seconds of head and torso on the joints of the bust. Running it writes dance.bvh.

No; yes, from the chest; circles; and no again, faster.
"""

from pathlib import Path

import numpy as np
from bust_clip import bust_clip, rise

from hairpipe.graphs.assets.bvh_writing import write_bvh
from hairpipe.values.body import Clip

RATE = 60.0  # samples a second
SECONDS = 10.4

# Shares of every joint in yaw, nod and roll, and how late it takes part [s]: the chest leads, the head follows.
SHARES = {
    "chest": (0.15, 0.30, 0.25, 0.0),
    "neck": (0.20, 0.20, 0.20, 0.02),
    "neck1": (0.25, 0.20, 0.25, 0.04),
    "head": (0.40, 0.30, 0.30, 0.06),
}
# What the head does: amplitudes of yaw, nod and roll [deg], times a second, from when to when [s].
PHRASES = (
    (50.0, 0.0, 8.0, 1.8, 0.3, 2.6),
    (0.0, 40.0, 0.0, 1.6, 2.4, 5.0),
    (45.0, 15.0, 25.0, 1.2, 4.8, 7.6),
    (55.0, 6.0, 10.0, 2.2, 7.4, 9.8),
)
FADE = 0.4
"""Time in which a phrase begins, and ends [s]."""


def make_clip() -> Clip:
    """Return the clip, in metres."""
    time = np.arange(round(SECONDS * RATE) + 1) / RATE
    _, nod, roll = head_angles(time).T
    sway = np.stack([1e-3 * roll, -2e-4 * np.abs(nod), 8e-4 * nod], axis=1)
    turns = [head_angles(time - late) * shares for *shares, late in SHARES.values()]
    return bust_clip(sway, turns, RATE)


def head_angles(time: np.ndarray) -> np.ndarray:
    """Return yaw, nod and roll of the head [deg], (n, 3); yaw and roll swing, a quarter of a swing apart."""
    angles = np.zeros((len(time), 3))
    for yaw, nod, roll, often, begin, end in PHRASES:
        swell = rise(time, begin, begin + FADE) * (1.0 - rise(time, end - FADE, end))
        phase = 2.0 * np.pi * often * (time - begin)
        angles += np.stack([yaw * np.sin(phase), nod * np.sin(phase), roll * np.cos(phase)], axis=1) * swell[:, None]
    return angles


if __name__ == "__main__":
    write_bvh(Path(__file__).with_suffix(".bvh"), make_clip())
