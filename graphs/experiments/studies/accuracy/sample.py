"""Settings of a measured strand, and of its shape."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.laws.settings import Construction
from hairpipe.strands.material import Material
from hairpipe.strands.registry import ModelName
from hairpipe.units import Gt, Interval, Metres

Segments = tuple[Annotated[int, Interval(ge=2, le=400)], ...]
"""Numbers of segments of strands that are compared."""
Numbers = tuple[Annotated[float, Gt(0.0)], ...]
"""Values of a parameter of the strands."""


@dataclass(frozen=True)
class Sample:
    """Model, material and length of a strand.

    model         name of the strand model
    material      material of the fibre
    construction  parameters of the network
    constants     spring constants of the network: calibrated, or the estimate E I / l^2 with altitude springs as a
                  share of it
    length        length of the strand
    """

    model: ModelName = "network"
    material: Material = Material()  # noqa: RUF009 (frozen)
    construction: Construction = Construction()  # noqa: RUF009
    constants: Literal["calibrated", "guessed"] = "calibrated"
    length: Annotated[Metres, Gt(0.0)] = 0.3

    def name(self, segments: int) -> str:
        """Name a strand of so many segments in a table."""
        return f"{self.model}, {segments} segments"


@dataclass(frozen=True)
class Spiral:
    """A curve whose curvature grows evenly along it.

    start  radius of curvature at the root
    end    radius of curvature at the tip
    turn   length in which the torsion, the same all along, makes a turn
    """

    start: Annotated[Metres, Gt(0.0)] = 0.2
    end: Annotated[Metres, Gt(0.0)] = 0.022
    turn: Annotated[Metres, Gt(0.0)] = 0.4
