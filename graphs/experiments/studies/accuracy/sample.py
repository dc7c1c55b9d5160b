"""Settings of a measured strand."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.sim.material import Material
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.registry import ModelName
from hairpipe.units import Gt, Metres


@dataclass(frozen=True)
class Sample:
    """What a strand is made of.

    model         of a strand
    material      of the fibre
    construction  of the network
    constants     of the network's springs: calibrated, or E I / l^2, as one might guess, with altitude springs a share
                  of it
    length        of the strand
    """

    model: ModelName = "network"
    material: Material = Material()  # noqa: RUF009 (frozen)
    construction: Construction = Construction()  # noqa: RUF009
    constants: Literal["calibrated", "guessed"] = "calibrated"
    length: Annotated[Metres, Gt(0.0)] = 0.3

    def name(self, segments: int) -> str:
        """Name a strand of so many segments in a table."""
        return f"{self.model}, {segments} segments"
