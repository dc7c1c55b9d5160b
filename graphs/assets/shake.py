"""Generated motion: a vigorous head shake on the joints of the bust. Running it writes shake.bvh."""

from pathlib import Path

import numpy as np
from bust_clip import bust_clip, rise

from hairpipe.graphs.assets.bvh_writing import write_bvh
from hairpipe.values.body import Clip

RATE = 120.0  # samples a second
SECONDS = 2.7
STILL = 0.2  # before anything moves [s]

# Shares of every joint in yaw, nod and roll, and how late it takes part [s]: the neck leads, the head follows.
SHARES = {
    "chest": (-0.07, 0.10, 0.10, 0.05),
    "neck": (0.22, 0.25, 0.25, 0.0),
    "neck1": (0.30, 0.30, 0.30, 0.012),
    "head": (0.55, 0.45, 0.45, 0.03),
}


def make_clip() -> Clip:
    """Return the clip, in metres."""
    time = np.arange(round(SECONDS * RATE) + 1) / RATE
    sway = np.stack([0.012 * shake(time - 0.06), 0.003 * bob(time), 0.006 * bob(time)], axis=1)
    return bust_clip(sway, [joint_angles(time, *shares) for shares in SHARES.values()], RATE)


def joint_angles(time: np.ndarray, yaw: float, nod: float, roll: float, late: float) -> np.ndarray:
    """Return the yaw, nod and roll of a joint [deg], (n, 3)."""
    time = time - late
    return np.stack([yaw * 47.0 * shake(time), nod * 9.0 * bob(time), -roll * 8.0 * shake(time - 0.05)], axis=1)


def shake(time: np.ndarray) -> np.ndarray:
    """Return the swing from side to side, within -1..1: two a second, swelling, then dying away."""
    swell = rise(time, STILL, STILL + 0.55) * (1.0 - 0.93 * rise(time, 1.45, 2.55))
    return swell * np.sin(2.0 * np.pi * 2.1 * np.maximum(time - STILL, 0.0))


def bob(time: np.ndarray) -> np.ndarray:
    """Return the dip of the head that goes with it, twice as often, within 0..1."""
    return shake(time) ** 2


if __name__ == "__main__":
    write_bvh(Path(__file__).with_suffix(".bvh"), make_clip())
