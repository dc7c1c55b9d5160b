"""Settings of a simulation of strands, in physical units."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.laws.settings import (
    Air,
    BodyContact,
    Collisions,
    Construction,
    Goal,
    Locks,
    Rest,
    Scheme,
    StepControl,
    Stiction,
    StrainLimit,
    Volume,
    Wind,
)
from hairpipe.strands.material import VariedMaterial
from hairpipe.strands.registry import ModelName
from hairpipe.units import (
    Interval,
    MetresPerSecondSquared,
    Replaces,
)

FORMER = (
    ("curvature", "its value as rest.shape"),
    ("sag_free", "rest.balanced = 1.0, and its settings unstable and strain as those of rest"),
)
"""What replaces settings of former releases."""


@dataclass(frozen=True)
class Scene:
    """Forces, contacts and time integration of a simulation.

    gravity     gravitational acceleration along -Y
    air         drag of still air
    contact     contact with bodies, whole level sets and parts; if absent, hair passes through bodies
    strain      strain limit of segments; if `false`, the springs alone limit the strain
    steps       limits that divide a frame into steps
    scheme      time integration scheme of a step
    rest        shape of hair at rest, and whether it begins in equilibrium
    stiction    connections between close strands until they are pulled apart; if absent, there are none
    collisions  repulsion between strands; if absent, strands pass through each other
    volume      drag and pressure between strands, on a grid; if absent, there are none
    locks       one simulation for strands that move together; if absent, every strand is simulated
    wind        moving air, in place of `air`; if absent, air is still
    goal        pull to the groom as carried by the skin; if absent, there is none
    """

    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81
    air: Air = Air()
    contact: BodyContact = BodyContact()
    strain: StrainLimit | None = StrainLimit()
    steps: StepControl = StepControl()
    scheme: Scheme = Scheme()
    rest: Annotated[Rest, Replaces(FORMER)] = Rest()
    stiction: Stiction | None = None
    collisions: Collisions | None = None
    volume: Volume | None = None
    locks: Locks | None = None
    wind: Wind | None = None
    goal: Goal | None = None

    @property
    def air_interacts(self) -> bool:
        """Whether air is an interaction, as wind and drag that varies are: solves then contain no drag of their own."""
        return self.wind is not None or not self.air.drag.is_constant


@dataclass(frozen=True)
class HairSettings(Scene):
    """All settings of a simulation of strands: the model of hair and its scene.

    model         strand model: rod (elastic rod with twist), network (of springs, as published; less accurate at equal
                  segments), chain (straight hair without twist)
    precision     floating-point precision of the solver: automatic uses single precision where that is safe
    material      material of the fibre, which determines the spring constants
    construction  parameters of the network, for experiments with its parts
    """

    model: ModelName = "rod"
    precision: Literal["automatic", "double", "single"] = "automatic"
    material: VariedMaterial = VariedMaterial()
    construction: Construction = Construction()
