"""Number of segments of strands: given, by their length, or by the shape of strands."""

from dataclasses import dataclass

import numpy as np

from hairpipe.errors import BadInput

SHORTEST = 0.001
"""Segment that hair of common material bears [m]: 80 um, softened by 100, is a rod down to 0.63 mm."""
FINE, A_TURN = 0.005, 16
"""Segment of straight hair [m], and segments in a turn of a curl."""
FEWEST, MOST, LATTICE = 25, 200, 5
"""Segments of a strand; in whole runs of the lattice, which turns one way for five (`sim/strands/lattice.py`)."""
ROUNDING = 1e-9


@dataclass(frozen=True)
class Cut:
    """Division of strands into segments; raises BadInput if both a number and a length are given.

    segments        number of segments of every strand; None: not given
    segment_length  maximum length of a segment [m]; None: not given
    shortest        minimum length of a segment [m]
    """

    segments: int | None = None
    segment_length: float | None = None
    shortest: float = SHORTEST

    def __post_init__(self) -> None:
        if self.segments is not None and self.segment_length is not None:
            both = f"segments = {self.segments} and segment_length = {self.segment_length:g} are both given"
            raise BadInput(both, right="one of the two")

    def wanted(self, lengths: np.ndarray | float, unless_said: np.ndarray | int) -> np.ndarray:
        """Return how many segments strands of given lengths [m] are asked to have, (S,) int64."""
        if self.segment_length is not None:
            asked = np.maximum(np.ceil(np.asarray(lengths) / self.segment_length - ROUNDING), 1.0)
            return asked.astype(np.int64)
        asked = unless_said if self.segments is None else self.segments
        return np.broadcast_to(asked, np.shape(lengths)).astype(np.int64)

    def bearable(self, lengths: np.ndarray) -> np.ndarray:
        """Return how many segments strands of given lengths [m] bear, (S,) int64; 0 where they are shorter than one."""
        return np.floor(lengths / self.shortest + ROUNDING).astype(np.int64)


def fitting(lengths: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return the number of segments that hair needs, (S,) int64; pure.

    One for every FINE of the length, A_TURN for every turn of a curl, from FEWEST to MOST, rounded up to whole periods
    of the lattice. Against rod theory the tip of a cantilever of 5 to 25 cm is then within 0.7 % of its length, the
    stiffness of helices of 4 to 15 mm within 3 %, where half as many leave 12 to 21 %.

    lengths  lengths of the strands [m], (S,)
    turns    arc length of a turn of their curls [m], (S,); inf for straight strands
    """
    needed = lengths * np.maximum(1.0 / FINE, A_TURN / turns)
    runs = np.ceil(np.clip(needed, FEWEST, MOST) / LATTICE - ROUNDING)
    return (LATTICE * runs).astype(np.int64)
