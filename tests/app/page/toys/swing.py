"""The hair of the shot."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hairpipe.engine import Time, node
from hairpipe.units import Interval, Metres
from hairpipe.values import Mesh, Strands


@dataclass(frozen=True)
class Wave:
    """A wave along the strands.

    height  of it
    """

    height: Annotated[Metres, Interval(ge=0.0, le=1.0)] = 0.02


@node(frames="each")
def swing(
    plate: Mesh, time: Time, *, strands: Annotated[int, Interval(ge=1, le=100_000)] = 200, wave: Wave | None = Wave()
) -> Strands:
    """Strands on a plate that wave with time.

    strands  in all
    wave     of the hair
    """
    height = wave.height if wave else 0.0
    rows = np.arange(strands)
    roots = np.stack([0.19 * ((rows * 0.618) % 1.0 - 0.5), np.zeros(strands), 0.19 * (rows / strands - 0.5)], axis=1)
    along = np.linspace(0.0, 1.0, 12)[None, :, None] * np.array([0.0, 0.2, 0.0])
    phase = 0.4 * time.frame + 3.0 * np.linspace(0.0, 1.0, 12)[None, :] + 0.02 * rows[:, None]
    points = roots[:, None] + along
    points[..., 0] += height * np.sin(phase) * np.linspace(0.0, 1.0, 12)
    speeds = np.zeros((12 * strands, 3), np.float32)
    speeds[:, 0] = (height * np.cos(phase)).ravel()
    return Strands(points.reshape(-1, 3), speeds, np.arange(strands + 1, dtype=np.int32) * 12, 1e-4)
