"""What a shot says about its hair, in physical terms."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.sim.air.wind import Wind
from hairpipe.sim.material import Material
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.registry import ModelName
from hairpipe.units import (
    Fraction,
    Ge,
    Gt,
    Interval,
    KilogramsPerCubicMetre,
    Metres,
    MetresPerSecondSquared,
    Newtons,
    NewtonsPerMetre,
    PerSecond,
    Seconds,
    SecondsSquaredPerMetreSquared,
)


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
    interpolation  of whole level sets between frames: two_sided as published, but that where one frame alone knows a
                   velocity it is taken whole, not halved (which is better); linear and one_sided beside it
    folds          share of their shape that a body leaves to curls; without, they keep it by their springs alone
    """

    friction: Annotated[float, Ge(0.0)] = 0.3
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 1e-3
    interpolation: Literal["two_sided", "linear", "one_sided"] = "two_sided"
    folds: Fraction | None = None


@dataclass(frozen=True)
class Stiction:
    """Hair that came close sticks together until it is pulled apart: Sec. 5.2, in physical terms.

    reach    distance at which segments stick, and that their connection would keep
    release  distance at which it lets go, at once
    force    with which it pulls at that moment
    closest  connections that a segment may have
    damping  of a connection, a fraction of critical damping
    """

    reach: Annotated[Metres, Interval(gt=1e-6, le=0.05)] = 5e-4
    release: Annotated[Metres, Interval(gt=1e-6, le=0.1)] = 1.5e-3
    force: Annotated[Newtons, Interval(ge=0.0, le=1.0)] = 2e-5
    closest: Annotated[int, Interval(ge=1, le=16)] = 5
    damping: Annotated[float, Ge(0.0)] = 0.5


@dataclass(frozen=True)
class Collisions:
    """Hair pushes hair away and does not pass through it.

    thickness  distance that is kept between the axes of two hairs
    friction   Coulomb coefficient
    stiffness  of two hairs that are pressed together; softer is faster, and gives way under tens of hairs
    solver     coupled: in one system with the strands, which stacks need; sweep: impulses pair by pair, as published,
               in schemes other than the nine steps once, on the velocities that a step ends with: it adds energy
    sweeps     over all pairs, of the published solver
    attempts   to resolve the crossings of a step
    """

    thickness: Annotated[Metres, Interval(gt=1e-6, le=0.02)] = 3e-4
    friction: Annotated[float, Ge(0.0)] = 0.3
    stiffness: Annotated[NewtonsPerMetre, Interval(gt=0.0, le=1e4)] = 0.1
    solver: Literal["coupled", "sweep"] = "coupled"
    sweeps: Annotated[int, Interval(ge=1, le=100)] = 3
    attempts: Annotated[int, Interval(ge=1, le=20)] = 4


@dataclass(frozen=True)
class Pressure:
    """Hair that is denser than it may be spreads.

    density     that hair may have; without, that of the groom where it is densest, so that it stands as groomed
    compliance  of denser hair: density over pressure
    """

    density: Annotated[KilogramsPerCubicMetre, Gt(0.0)] | None = None
    compliance: Annotated[SecondsSquaredPerMetreSquared, Interval(ge=0.0, le=100.0)] = 0.1


@dataclass(frozen=True)
class Target:
    """Hair is led to where a density of hair is, another simulation's, a groom's or a file's.

    The density is taken as of so much hair as there is: one of fewer hairs, or in another unit, leads to the
    same place.

    cell    of the finest grid
    levels  grids, each of cells twice as large as the last: coarse ones lead hair that is far away
    rate    at which hair would swing about where it is led to
    """

    cell: Annotated[Metres, Interval(ge=5e-4, le=0.2)] = 0.012
    levels: Annotated[int, Interval(ge=1, le=6)] = 5
    rate: Annotated[PerSecond, Interval(gt=0.0, le=1e4)] = 30.0


@dataclass(frozen=True)
class Volume:
    """Hair as one material on a grid, after Petrovic, Henne, Anderson 2005.

    Hairs slow each other down and keep room without being looked at pair by pair. It makes no locks, and hair may cross
    hair.

    cell       spacing of the nodes
    friction   rate at which hair takes over the velocity of the hair around it
    order      1: all that differs from the mean around it is slowed; 2: only what varies from hair to hair
    smoothing  passes over the grid; cells of twice the size do what eight passes do
    pressure   one-sided; without, hair may be as dense as it likes
    target     where `in.target` is dense, hair is led; without, nowhere
    """

    cell: Annotated[Metres, Interval(ge=5e-4, le=0.2)] = 0.006
    friction: Annotated[PerSecond, Interval(ge=0.0, le=1e5)] = 120.0
    order: Annotated[int, Interval(ge=1, le=2)] = 1
    smoothing: Annotated[int, Interval(ge=0, le=8)] = 1
    pressure: Pressure | None = None
    target: Target | None = None


@dataclass(frozen=True)
class Locks:
    """Hair that moves together is simulated once.

    Hairs whose connections of stiction last become a lock: one of them is simulated, its guide, and keeps the distances
    of as many hairs; the others are carried by the guides beside them, until these disagree.

    after      frames that a connection has lasted when it counts
    part       of the segments of a hair that have such connections to another, for the two to be joined
    most       hairs in a lock
    tolerance  of where a hair is that follows; where its guides disagree by more, or a body pushes it farther, it is
               simulated again, until what it left would have carried it as well for `after` frames
    audit      share of the locks, of eight and more two at least, that are simulated with all their hairs at a time, by
               turns, for as long as a connection must last: those that are off by more than the tolerance part; 0: none
    """

    after: Annotated[int, Interval(ge=1, le=10_000)] = 5
    part: Annotated[float, Interval(gt=0.0, le=5.0)] = 0.5
    most: Annotated[int, Interval(ge=2, le=100_000)] = 16
    tolerance: Annotated[Metres, Interval(gt=0.0, le=1.0)] = 4e-3
    audit: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.02


@dataclass(frozen=True)
class StrainLimit:
    """How far a segment may be stretched at the end of a step.

    tolerance  over its rest length
    """

    tolerance: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.02


@dataclass(frozen=True)
class StepControl:
    """Steps as long as they may be, and no longer.

    longest      step
    root         a root moves at most this far in a step: 1 cm in the authors' code
    travel       a particle moves at most this far in a step, and so does a body: what is pushed farther is stretched
    strain_rate  an edge changes its length by at most this fraction of it in a step; 0.1 in the authors' code
    courant      so many times what an explicit step could be; 4 and 10 in the authors' code
    crossings    pairs of segments a segment that may have to be kept from passing through each other in a step; with
                 more, steps get shorter, down to a quarter of the longest
    most         steps in a frame; a shot that asks for more is ended, and the strand and the setting are named
    """

    longest: Annotated[Seconds, Interval(gt=1e-6, le=1.0)] = 1 / 240
    root: Annotated[Metres, Interval(gt=1e-5, le=1e3)] = 0.01
    travel: Annotated[Metres, Interval(gt=1e-5, le=1e3)] = 0.02
    strain_rate: Annotated[float, Gt(0.0)] | None = None
    courant: Annotated[float, Gt(0.0)] | None = None
    crossings: Annotated[float, Gt(0.0)] = 0.01
    most: Annotated[int, Interval(ge=1, le=10**9)] = 20_000


@dataclass(frozen=True)
class Scheme:
    """How a step of time is computed.

    value         tr_bdf2: two solves, second order; bdf2: one, second order; backward_euler: one, first order;
                  nine_steps: as published
    spring        what of a spring is implicit: multiplier, with the tension that the solve before found; tension, with
                  that of the present stretch; printed, along the spring only; explicit, nothing but damping
    velocity      of the nine steps: trapezoid as printed, full_step as in the authors' code
    overdamping   damping of the springs over critical damping; 40 in the authors' code
    iterations    of Newton's method a solve
    guard         strain of an edge at the prediction beyond which a strand starts its solve over, from where it was, or
                  where something acts on hair, from where backward Euler leads it alone
    """

    value: Literal["tr_bdf2", "bdf2", "backward_euler", "nine_steps"] = "tr_bdf2"
    spring: Literal["multiplier", "tension", "printed", "explicit"] = "multiplier"
    velocity: Literal["trapezoid", "full_step"] = "trapezoid"
    overdamping: Annotated[float, Ge(0.0)] = 0.0
    iterations: Annotated[int, Interval(ge=1, le=20)] = 1
    guard: Annotated[float, Gt(0.0)] = 0.03


@dataclass(frozen=True)
class SagFree:
    """Hair starts at rest in the shape of the groom, which its springs carry, and stays so while nothing moves it.

    unstable  what becomes of strands too long or too soft to stand so: they fall, as all hair does without this group;
              they settle, and start in the shape that they sag to; or the shot is refused
    strain    of a spring, beyond which a strand is called too soft
    """

    unstable: Literal["fall", "settle", "refuse"] = "fall"
    strain: Annotated[float, Interval(gt=0.0, le=1.0)] = 0.3


@dataclass(frozen=True)
class Scene:
    """What hair moves in, and how that is computed.

    gravity     along -Y
    air         what slows hair where nothing touches it
    contact     how it touches bodies, whole level sets and those in parts; without any it passes through
    strain      how far a segment may be stretched; without, as far as its springs let it
    steps       how a frame is cut into steps
    scheme      how a step is computed
    sag_free    start at rest as groomed; without, springs rest in the groom's shape and hair sags from it
    stiction    hair that came close sticks together until it is pulled apart
    collisions  hair pushes hair away and does not pass through it
    volume      hairs slow each other down and keep room through a grid
    locks       hair that sticks together is simulated once; without, every hair is
    wind        moving air; without, it is still
    """

    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81
    air: Air = Air()
    contact: BodyContact = BodyContact()
    strain: StrainLimit | None = None
    steps: StepControl = StepControl()
    scheme: Scheme = Scheme()
    sag_free: SagFree | None = None
    stiction: Stiction | None = None
    collisions: Collisions | None = None
    volume: Volume | None = None
    locks: Locks | None = None
    wind: Wind | None = None


@dataclass(frozen=True)
class HairSettings(Scene):
    """All that a graph says of a simulation: the scene, and the hair in it.

    model         network: as published; rod: an elastic rod, as true at half the segments, with its twist; chain:
                  straight hair without twist, at half the particles
    precision     of the numbers; automatic: single where that is safe, see `sim/precision.py`
    material      of the fibre; the spring constants are calibrated from it
    construction  of the network, to take apart what it consists of
    """

    model: ModelName = "network"
    precision: Literal["automatic", "double", "single"] = "automatic"
    material: Material = Material()  # noqa: RUF009 (frozen)
    construction: Construction = Construction()  # noqa: RUF009
