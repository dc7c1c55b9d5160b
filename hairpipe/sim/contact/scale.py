"""The scale of a scene: tolerances of contact follow it, so that a scene of another size has the same motion.

Lengths are in proportion to the distance d that hair keeps, times to sqrt(d / g), speeds to sqrt(d g), with g the
gravity: the similarity of Froude. Tolerances are written for the default distance under the Earth's gravity; a scene
without gravity has the times of this one.
"""

from typing import NamedTuple

import numpy as np

_EARTH = 9.81  # [m/s^2]


class Scale(NamedTuple):
    """Factors on tolerances of contact [1]."""

    length: float = 1.0
    time: float = 1.0
    speed: float = 1.0


USUAL = Scale()


def scale_of(distance: float, usual: float, gravity: float) -> Scale:
    """Return the scale of a scene; pure.

    distance  that hair keeps [m], and the `usual` one, for which tolerances are written
    gravity   [m/s^2]
    """
    length = distance / usual
    time = float(np.sqrt(length * _EARTH / (gravity or _EARTH)))
    return Scale(length, time, length / time)
