"""A motion capture clip as recorded: a skeleton and the channels of its joints, in the units of its file."""

import numpy as np

from hairpipe.data.value import value


@value
class Clip:
    """The joints of a performer and their channels over time; a parent stands before its children.

    names       of the joints, J of them
    parents     index of the parent joint, -1 at a root, (J,) int32
    offsets     of every joint from its parent where all channels are zero [file units], (J, 3) float64
    ends        of the End Site of a joint from it [file units], (J, 3) float64, NaN where it has none
    channels    of every joint in the order of the file, such as ("Xposition", "Zrotation")
    values      of all channels, joint after joint [file units, deg], (F, C) float64; positions in place of offsets
    frame_time  from one frame to the next [s]
    """

    names: tuple[str, ...]
    parents: np.ndarray
    offsets: np.ndarray
    ends: np.ndarray
    channels: tuple[tuple[str, ...], ...]
    values: np.ndarray
    frame_time: float
