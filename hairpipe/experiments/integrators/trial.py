"""What hair is put through: single strands, each led through a motion of its own."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np

from hairpipe.data import Ends, Groom
from hairpipe.groom.adopting import offsets_of
from hairpipe.groom.strands import lay_strands
from hairpipe.motion.ends import lead
from hairpipe.motion.track import Track
from hairpipe.motion.wave import Wave
from hairpipe.sim.material import Material
from hairpipe.units import Degrees, Gt, Interval, Metres, PerSecond, Seconds

MotionName = Literal["rest", "swing", "shake 600 deg/s", "square wave", "shake 2500 deg/s"]
_LEVER = (0.0, 0.0, -0.1)
"""From a root to the axis that a head turns about [m]."""


@dataclass(frozen=True)
class Moved:
    """How a strand starts and how its root is led.

    from_hanging  angle of the straight strand from hanging down, at the start
    wave          that leads the root; it stands still without
    drag          of the air: where a strand is thrown about with little of it the motion is chaotic, and no answer to
                  compare with exists
    """

    from_hanging: Degrees = 0.0
    wave: Wave | None = None
    drag: PerSecond = 0.1


MOTIONS: dict[str, Moved] = {
    "rest": Moved(),
    "swing": Moved(from_hanging=60.0),
    "shake 600 deg/s": Moved(wave=Wave("sine", 2.0, turning=600.0, pivot=_LEVER), drag=10.0),
    "square wave": Moved(wave=Wave("square", 2.0, 2.0, turning=360.0, axis=(0.0, 0.0, 1.0)), drag=10.0),
    "shake 2500 deg/s": Moved(wave=Wave("sine", 2.0, turning=2500.0, pivot=_LEVER), drag=10.0),
}
"""Motions by name, from calm to violent: a square wave of +-2 m/s turns by 360 deg/s, too."""


@dataclass(frozen=True)
class Strand:
    """One strand and its motion."""

    motion: MotionName
    length: float


@dataclass(frozen=True)
class Trial:
    """Strands of every length through every motion.

    motions   rest and swing in thin air, the others with a drag of 10 1/s
    lengths   of the strands
    segments  of each strand
    seconds   from the start; samples are taken 24 times a second
    material  of the fibre
    """

    motions: tuple[MotionName, ...] = ("swing",)
    lengths: tuple[Annotated[Metres, Gt(0.0)], ...] = (0.3, 0.1)
    segments: Annotated[int, Interval(ge=1, le=1000)] = 50
    seconds: Annotated[Seconds, Gt(0.0)] = 3.0
    material: Material = field(default_factory=Material)

    @property
    def strands(self) -> list[Strand]:
        """List the strands, motion by motion."""
        return [Strand(motion, length) for motion in self.motions for length in self.lengths]


def groom_of(strands: list[Strand], segments: int) -> Groom:
    """Lay strands as they start, all roots in one place: nothing touches them."""
    points, frames = [], []
    for strand in strands:
        angle = np.radians(MOTIONS[strand.motion].from_hanging)
        direction = float(np.sin(angle)), -float(np.cos(angle)), 0.0
        one = lay_strands(1, strand.length, segments, direction, (0.0, 0.0, 0.0), None, 0.0)
        points.append(one.points)
        frames.append(one.root_frames)
    count = len(strands)
    return Groom(
        points=np.concatenate(points),
        offsets=offsets_of(np.full(count, segments + 1)),
        ids=np.arange(count, dtype=np.int32),
        root_triangles=np.zeros(count, np.int32),
        root_barycentrics=np.tile([1.0, 0.0, 0.0], (count, 1)),
        root_frames=np.concatenate(frames),
        root_uv=np.zeros((count, 2), np.float32),
    )


def ends_at(strands: list[Strand], groom: Groom, time: float) -> Ends:
    """Find where the ends of strands are led at a time [s]; tips are free."""
    led = {strand.motion: lead(groom, time, Track(), MOTIONS[strand.motion].wave, None, None) for strand in strands}
    mine = [(led[strand.motion], n) for n, strand in enumerate(strands)]
    return Ends(
        np.stack([ends.roots[n] for ends, n in mine]),
        np.stack([ends.roots_rate[n] for ends, n in mine]),
        np.stack([ends.tips[n] for ends, n in mine]),
        np.stack([ends.tips_rate[n] for ends, n in mine]),
    )
