"""What a shot says about its hair, in physical terms."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.units import Ge, Interval, Metres, MetresPerSecondSquared, PerSecond, Seconds


@dataclass(frozen=True)
class Air:
    """Still air.

    drag  rate at which it takes away speed; a lone hair feels 15 to 20, one among others less, as its air moves along
    """

    drag: Annotated[PerSecond, Interval(ge=0.0, le=1000.0)] = 8.0


@dataclass(frozen=True)
class BodyContact:
    """How hair touches the body.

    friction       Coulomb coefficient
    thickness      distance kept from the surface, from the fifth particle on; one fifth of it at the first
    interpolation  of the level set between frames: two_sided as published, linear and one_sided beside it
    """

    friction: Annotated[float, Ge(0.0)] = 0.3
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 1e-3
    interpolation: Literal["two_sided", "linear", "one_sided"] = "two_sided"


@dataclass(frozen=True)
class StrainLimit:
    """How far a segment may be stretched at the end of a step.

    tolerance  over its rest length
    """

    tolerance: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.02


@dataclass(frozen=True)
class StepControl:
    """Steps as long as they may be, and no longer.

    longest  step
    root     a root moves at most this far in a step: 1 cm in the authors' code
    travel   a particle moves at most this far in a step, so that it cannot leap over the band of the level set
    """

    longest: Annotated[Seconds, Interval(gt=1e-6, le=1.0)] = 1 / 240
    root: Annotated[Metres, Interval(gt=1e-5, le=1.0)] = 0.01
    travel: Annotated[Metres, Interval(gt=1e-5, le=1.0)] = 0.02


@dataclass(frozen=True)
class Scene:
    """All of it together; gravity acts along -Y."""

    gravity: MetresPerSecondSquared = 9.81
    air: Air = Air()
    contact: BodyContact = BodyContact()
    strain: StrainLimit = StrainLimit()
    steps: StepControl = StepControl()
