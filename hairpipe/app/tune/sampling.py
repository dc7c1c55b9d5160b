"""Strands and frames that represent a scene, and the hardest motion of its roots, which a promise holds for."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

STRANDS = 96
PATCHES = 4
"""Number of patches of neighbouring strands where hair acts on hair; else every strand is a patch."""
LEAD, LONG = 0.5, 0.5  # durations of settling and of measuring [s]


@dataclass(frozen=True)
class Sample:
    """Strands and frames of a scene."""

    strands: int  # sampled strands, in patches of neighbours
    patches: int
    number: int  # number of the sample: samples of different numbers have no common strands
    begin: int  # frame at which the simulation starts
    first: int  # first measured frame
    last: int  # last measured frame

    @property
    def frames(self) -> range:
        return range(self.first, self.last + 1)

    @property
    def simulated(self) -> range:
        return range(self.begin, self.last + 1)


def choose_sample(
    frames: range, fps: float, motion: np.ndarray | None, total: int, strands: int, patches: int
) -> Sample:
    """Choose strands, and the frames with the largest acceleration of the roots, preceded by as many to settle.

    frames  frames of the shot
    motion  acceleration of the roots at every frame [m/s^2], (frames,); None for roots at rest
    total   number of strands
    """
    patches = min(patches, total)
    size = min(-(-strands // patches) * patches, total)
    whole = Sample(size, patches, 0, frames[0], frames[0], frames[-1])
    return window(whole, frames, fps, np.zeros(len(frames)) if motion is None else motion)


def other_sample(samples: Sequence[Sample], frames: range, fps: float, motion: np.ndarray | None, total: int) -> Sample:
    """Choose other strands and frames than those of some samples, as far as the scene has enough.

    Without other strands they are those of the last sample, at frames at which these were not sampled.
    """
    last = samples[-1]
    number = min(len(samples), max(total // last.strands, 1) - 1)
    rest = np.zeros(len(frames)) if motion is None else motion.copy()
    for sample in [sample for sample in samples if sample.number == number] or samples:
        rest[[frame - frames[0] for frame in sample.frames]] = -1.0
    return window(replace(last, number=number), frames, fps, rest)


def window_length(count: int, fps: float) -> int:
    return min(max(round(LONG * fps), 2), count - 1) or 1


def window(sample: Sample, frames: range, fps: float, motion: np.ndarray) -> Sample:
    """Place a sample where the mean square of the motion is largest, at the first such place that can settle before.

    Negative motion excludes a frame; if every place contains such frames, it is the one with the fewest.
    """
    lead = round(LEAD * fps)
    length = window_length(len(frames), fps)
    starts = np.arange(min(1, len(frames) - 1), len(frames) - length + 1)
    outside = np.array([np.count_nonzero(motion[s : s + length] < 0.0) for s in starts])
    strength = np.array([np.mean(np.maximum(motion[s : s + length], 0.0) ** 2) for s in starts])
    hurried = np.maximum(lead - starts, 0)
    best = starts[np.lexsort((starts, hurried, -np.round(strength / max(strength.max(), 1e-300), 6), outside))[0]]
    first = frames[int(best)]
    return replace(sample, begin=max(first - lead, frames[0]), first=first, last=first + length - 1)


SLACK = 1.02  # ratio up to which two motions are as hard: figures are printed with three digits


@dataclass(frozen=True)
class RootMotion:
    """The hardest motion of roots, root mean square over the strands."""

    speed: float  # largest of a frame [m/s]
    acceleration: float  # largest root mean square over half a second [m/s^2]

    def includes(self, other: "RootMotion") -> bool:
        """Whether another motion is no harder."""
        return other.speed <= SLACK * self.speed and other.acceleration <= SLACK * self.acceleration

    def __str__(self) -> str:
        return f"{self.speed:.3g} m/s and {self.acceleration:.3g} m/s^2"


STILL = RootMotion(0.0, 0.0)
"""That of roots that do not move."""


def hardest(speeds: np.ndarray, accelerations: np.ndarray, fps: float) -> RootMotion:
    """Return the hardest motion, from the root mean squares over the strands of all frames of a shot.

    speeds         of every frame [m/s], (frames,)
    accelerations  of every frame [m/s^2], (frames,)
    """
    length = window_length(len(accelerations), fps)
    squares = np.convolve(accelerations**2, np.full(length, 1.0 / length), "valid")
    return RootMotion(float(speeds.max()), float(np.sqrt(squares.max())))
