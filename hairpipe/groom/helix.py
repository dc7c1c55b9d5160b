"""A helix cut into equal segments."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.units import Ge, Gt, Metres

HALVINGS = 60  # of the interval that holds the turn: down to rounding


@dataclass(frozen=True)
class Helix:
    """A right-handed helix along the direction of the strand; its root lies on the helix.

    radius  of the helix, from its axis
    pitch   along the axis, for one turn
    """

    radius: Annotated[Metres, Gt(0.0)]
    pitch: Annotated[Metres, Ge(0.0)]


def wound(curl: Helix, length: float, segments: int) -> np.ndarray:
    """Return points on a helix along the third axis, (segments + 1, 3) [m], by chords of length / segments.

    The turn t of a chord c solves c^2 = (2 R sin(t / 2))^2 + (P t / 2 pi)^2, which grows with t up to half a turn.
    """

    def chord(turn: float) -> float:
        return np.hypot(2.0 * curl.radius * np.sin(turn / 2.0), curl.pitch * turn / (2.0 * np.pi))

    low, high, wanted = 0.0, np.pi, length / segments
    if chord(high) < wanted:
        fewest = int(np.ceil(length / chord(high)))
        raise BadInput(f"{segments} segments are more than half a turn each", right=f"segments >= {fewest}")
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if chord(middle) < wanted else (low, middle)
    turns = low * np.arange(segments + 1)
    around = curl.radius * np.column_stack([np.cos(turns) - 1.0, np.sin(turns)])
    return np.column_stack([around, curl.pitch * turns / (2.0 * np.pi)])
