"""Trials: single strands, each with a prescribed motion of its own."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from hairpipe.body.scripted_motion import Wave
from hairpipe.strands.material import Material
from hairpipe.strands.registry import ModelName
from hairpipe.units import Degrees, Gt, Interval, Metres, PerSecond, Seconds

MotionName = Literal["rest", "swing", "shake 600 deg/s", "square wave", "shake 2500 deg/s"]
_LEVER = (0.0, 0.0, -0.1)
"""From a root to the axis that a head turns about [m]."""


@dataclass(frozen=True)
class Moved:
    """Start of a strand, and motion of its root.

    from_hanging  angle of the straight strand from hanging down, at the start
    wave          motion of the root; fixed if absent
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
    """Strands of every length under every motion.

    motions   names of the motions: rest and swing in thin air, the others with a drag of 10 1/s
    lengths   lengths of the strands
    segments  number of segments of each strand
    seconds   duration of the run, sampled 24 times a second
    material  material of the fibre
    model     name of the strand model
    """

    motions: tuple[MotionName, ...] = ("swing",)
    lengths: tuple[Annotated[Metres, Gt(0.0)], ...] = (0.3, 0.1)
    segments: Annotated[int, Interval(ge=1, le=1000)] = 50
    seconds: Annotated[Seconds, Gt(0.0)] = 3.0
    material: Material = field(default_factory=Material)
    model: ModelName = "network"

    @property
    def strands(self) -> list[Strand]:
        """List the strands, motion by motion."""
        return [Strand(motion, length) for motion in self.motions for length in self.lengths]
