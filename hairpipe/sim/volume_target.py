"""Hair led to a density once a step: Petrovic, Henne, Anderson 2005, equation (3), see `volume/targeting.py`."""

from dataclasses import dataclass

import numpy as np

from hairpipe.data import Density
from hairpipe.sim.interactions import Interaction, StepEnd
from hairpipe.sim.settings import Target
from hairpipe.volume.targeting import Hair, TargetGrid, attraction, between, target_grids


@dataclass(eq=False)
class VolumeTarget(Interaction):
    """The density target of a frame.

    offsets        offsets of the points of strands, (S+1,) int32
    reach          see `sample_strands` [m], (S,)
    lengths        length of hair at each point, at rest [m], (P,)
    before, after  density at the previous frame and at this one, on all grids
    frame_dt       time between the two [s]
    """

    in_solve = False
    target: Target
    offsets: np.ndarray
    reach: np.ndarray
    lengths: np.ndarray
    before: list[TargetGrid]
    after: list[TargetGrid]
    frame_dt: float

    def correct(self, end: StepEnd) -> None:
        """Change velocities, in place."""
        share = (end.time + end.dt) / self.frame_dt
        still = self.before is self.after
        now = self.after if still else [between(*pair, share) for pair in zip(self.before, self.after, strict=True)]
        hair = Hair(end.points, self.offsets, self.reach, self.lengths)
        change = attraction(hair, now, self.target.rate, end.dt)
        change[np.isinf(end.masses)] = 0.0
        end.push(change)


def volume_target(
    target: Target,
    densities: tuple[Density, Density],
    strands: tuple[np.ndarray, np.ndarray, np.ndarray],
    frame_dt: float,
) -> VolumeTarget:
    """Make a target from offsets, reach and lengths of strands and densities at the previous frame and at this one.

    Raises BadInput as `target_grids` does.
    """
    (before, after), (offsets, reach, lengths) = densities, strands
    grids = target_grids(after, target.cell, target.levels, lengths.sum())
    still = np.array_equal(before.low, after.low) and np.array_equal(before.length, after.length)
    first = grids if still else target_grids(before, target.cell, target.levels, lengths.sum())
    return VolumeTarget(target, offsets, reach, lengths, first, grids, frame_dt)
