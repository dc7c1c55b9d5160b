"""The worst of a run in which a bar meets hair, and by which signs the run failed."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.studies.contact.bar import HALT, RADIUS, depth

GRAVITY = 9.81
STRETCHED = 0.1
INSIDE = 1e-3
GROWN = GRAVITY * RADIUS
"""What counts as failed: stretch of a segment, depth in the bar at a frame [m], energy that hair wins at rest [J/kg].

Of all that acts on hair when all else is at rest, only the bar adds to the energy: what is inside of it is pushed out,
and rises by its radius at most. What springs win by that is not allowed for.
"""
FLUNG, FLUNG_LEAST = 2.0, 1.0
"""A point is flung that is faster than so many times the fastest of the converged run, and so much more [m/s].

Not than the bar: ends of hair that slides off it whip, and do so at six times its speed.
"""


class Seen(NamedTuple):
    """Hair at one time.

    points, velocities  [m], [m/s], (P, 3)
    stretch             of the segment that is stretched most
    axis                a point of the axis of the bar [m], (3,); None: there is none
    """

    points: np.ndarray
    velocities: np.ndarray
    stretch: float
    axis: np.ndarray | None


@dataclass(eq=False)
class Worst:
    """The worst of a run so far.

    through    strands or links that went through the bar, (n,) bool
    deepest    point [m]; stretch of a segment; fastest point [m/s]
    shown      deepest point at the end of a frame [m]
    energies   of hair at the frames since the bar has come to rest, with what its springs hold [J/kg]
    simulated  strands or particles, where they were fewest
    """

    through: np.ndarray
    steps: int = 0
    deepest: float = 0.0
    shown: float = 0.0
    stretch: float = 0.0
    fastest: float = 0.0
    finite: bool = True
    energies: list[float] = field(default_factory=list)
    simulated: int = 0

    @property
    def grown(self) -> float:
        """Energy that hair has won since the bar came to rest, from one frame to any later one, at most [J/kg]."""
        return float(np.max(self.energies - np.minimum.accumulate(self.energies), initial=0.0))

    def note(self, seen: Seen) -> None:
        """Take in hair at one time, in place."""
        self.finite = bool(np.isfinite(seen.points).all() and np.isfinite(seen.velocities).all())
        self.fastest = max(self.fastest, float(np.linalg.norm(seen.velocities, axis=1).max()))
        self.stretch = max(self.stretch, seen.stretch)
        if seen.axis is not None and self.finite:
            self.deepest = max(self.deepest, depth(seen.points - seen.axis))

    def end_frame(self, seconds: float, seen: Seen, energy: float) -> None:
        """Take in hair at a frame, at a time since the start [s], and its energy [J/kg], in place."""
        if seen.axis is not None:
            self.shown = max(self.shown, depth(seen.points - seen.axis))
        if seconds >= HALT * (1.0 - 1e-9):
            self.energies.append(energy)


def signs(worst: Worst, possible: float) -> str:
    """List what failed, separated by commas; no point can be faster than possible [m/s]."""
    if not worst.finite:
        return "NaN"
    failed = {
        "through": worst.through.any(),
        "stretch": worst.stretch > STRETCHED,
        "flung": worst.fastest > possible,
        "inside": worst.shown > INSIDE,
        "growing": worst.grown > GROWN,
    }
    return ", ".join(sign for sign, seen in failed.items() if seen)
