"""Our own motion capture: a vigorous shake of the head, "no", on the joints of our bust. Run it to write shake.bvh."""

from pathlib import Path

import numpy as np

from hairpipe.body.bust import CROWN, JOINTS
from hairpipe.data.clip import Clip
from hairpipe.io.bvh_writing import write_bvh

RATE = 120.0  # samples a second
SECONDS = 2.7
STILL = 0.2  # before anything moves [s]
ROTATIONS = ("Yrotation", "Xrotation", "Zrotation")

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
    places = np.array(list(JOINTS.values()))
    sway = np.stack([0.012 * shake(time - 0.06), 0.003 * bob(time), 0.006 * bob(time)], axis=1)
    columns = [places[0] + sway]
    columns += [joint_angles(time, *shares) for shares in SHARES.values()]
    ends = np.full_like(places, np.nan)
    ends[-1] = np.array(CROWN) - places[-1]
    return Clip(
        names=tuple(JOINTS),
        parents=np.arange(-1, len(JOINTS) - 1, dtype=np.int32),
        offsets=np.concatenate([places[:1], np.diff(places, axis=0)]),
        ends=ends,
        channels=(("Xposition", "Yposition", "Zposition", *ROTATIONS), ROTATIONS, ROTATIONS, ROTATIONS),
        values=np.concatenate(columns, axis=1),
        frame_time=1.0 / RATE,
    )


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


def rise(time: np.ndarray, first: float, last: float) -> np.ndarray:
    """Return the step 6s^5 - 15s^4 + 10s^3 from 0 at `first` to 1 at `last`: no jump in the acceleration."""
    share = np.clip((time - first) / (last - first), 0.0, 1.0)
    return share**3 * (share * (6.0 * share - 15.0) + 10.0)


if __name__ == "__main__":
    write_bvh(Path(__file__).with_suffix(".bvh"), make_clip())
