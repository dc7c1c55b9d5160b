"""A motion capture clip as recorded: a skeleton and the channels of its joints, in the units of its file."""

import numpy as np

from hairpipe.data.value import value


@value
class Clip:
    """The joints of a performer and their channels over time; parents precede children.

    names       names of the J joints
    parents     index of the parent joint, -1 at a root, (J,) int32
    offsets     offset of every joint from its parent with all channels zero [file units], (J, 3) float64
    ends        offset of a joint's End Site from the joint [file units], (J, 3) float64, NaN if it has none
    channels    channels of every joint in the order of the file, such as ("Xposition", "Zrotation")
    values      values of all channels, by joint [file units, deg], (F, C) float64; positions replace offsets
    frame_time  duration of a frame [s]
    """

    names: tuple[str, ...]
    parents: np.ndarray
    offsets: np.ndarray
    ends: np.ndarray
    channels: tuple[tuple[str, ...], ...]
    values: np.ndarray
    frame_time: float
