"""Settings of laws, of steps and of locks, in physical units."""

from dataclasses import dataclass
from typing import Annotated, Literal

from hairpipe.errors import BadInput
from hairpipe.units import (
    Degrees,
    Fraction,
    Ge,
    Gt,
    Hertz,
    Interval,
    KilogramsPerCubicMetre,
    Metres,
    MetresPerSecond,
    Newtons,
    NewtonsPerMetre,
    PascalSeconds,
    PerSecond,
    Seconds,
    SecondsSquaredPerMetreSquared,
)
from hairpipe.values.painting import Varied

RATES = Interval(ge=0.0, le=1000.0)


@dataclass(frozen=True)
class Drag(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[PerSecond, RATES]
    low: Annotated[PerSecond, RATES] = 0.0


@dataclass(frozen=True)
class Air:
    """Still air.

    drag  damping rate of the velocity; 15 to 20 for an isolated strand, less inside a groom, whose air moves with it
    """

    drag: Drag = Drag(8.0)


Velocity = tuple[MetresPerSecond, MetresPerSecond, MetresPerSecond]


@dataclass(frozen=True)
class Coefficients:
    """Linear drag: force on a metre of hair at 1 m/s.

    normal      drag coefficient of flow across the hair
    tangential  drag coefficient of flow along the hair
    """

    normal: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 2e-4
    tangential: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 5e-5


@dataclass(frozen=True)
class Gusts:
    """Turbulent eddies, advected by the wind.

    strength  root mean square of each component of the velocity
    size      correlation length: the correlation along a line is exp(-(r / size)^2 / 2)
    duration  correlation time in the moving frame: the correlation is exp(-(t / duration)^2 / 2)
    seed      seed of the random numbers
    """

    strength: Annotated[MetresPerSecond, Interval(ge=0.0, le=100.0)] = 1.0
    size: Annotated[Metres, Interval(gt=1e-3, le=1e3)] = 0.5
    duration: Annotated[Seconds, Interval(gt=1e-3, le=1e4)] = 0.5
    seed: Annotated[int, Ge(0)] = 0


@dataclass(frozen=True)
class Shielding:
    """Reduction of the wind by hair upstream.

    cell   cell size of the grid of hair density; larger for a very wide groom
    hairs  number of hairs that a strand represents in the density
    """

    cell: Annotated[Metres, Interval(ge=1e-3, le=1.0)] = 0.01
    hairs: Annotated[float, Interval(ge=0.0, le=1e6)] = 1.0


@dataclass(frozen=True)
class Wind:
    """Moving air and the drag of a fibre in it, in place of `air.drag` for still air.

    velocity      mean velocity of the air; zero for the drag of still air
    density       mass density of the air
    viscosity     dynamic viscosity of the air
    coefficients  prescribed drag coefficients, in place of those of a cylinder at its Reynolds number
    gusts         turbulence of the wind; if absent, the wind is steady
    shielding     reduction of the wind by hair upstream; if absent, the wind is uniform
    """

    velocity: Velocity = (0.0, 0.0, -1.0)
    density: Annotated[KilogramsPerCubicMetre, Gt(0.0)] = 1.2
    viscosity: Annotated[PascalSeconds, Gt(0.0)] = 1.8e-5
    coefficients: Coefficients | None = None
    gusts: Gusts | None = None
    shielding: Shielding | None = None


FREQUENCIES = Interval(ge=0.0, le=1e4)


@dataclass(frozen=True)
class Frequency(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[Hertz, FREQUENCIES]
    low: Annotated[Hertz, FREQUENCIES] = 0.0


@dataclass(frozen=True)
class Goal:
    """Pull of every point of hair to its place in the groom, which the skin carries rigidly.

    frequency  natural frequency of a free point about its place; 0 where there is no pull
    damping    ratio of damping to critical damping, for motion relative to that place
    """

    frequency: Frequency = Frequency(4.0)
    damping: Annotated[float, Interval(ge=0.0, le=100.0)] = 1.0


@dataclass(frozen=True)
class BodyContact:
    """Contact of hair with bodies.

    friction       Coulomb friction coefficient between hair and bodies
    thickness      distance kept from the surface, from the fifth particle on; one fifth of it at the first
    interpolation  interpolation of whole level sets between frames: two_sided as published, except for velocities known
                   at one frame only, which keep their full value; linear; or one_sided
    folds          share of the rest shape that contact leaves to curls; if absent, springs alone hold the curls
    """

    friction: Annotated[float, Ge(0.0)] = 0.3
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 1e-3
    interpolation: Literal["two_sided", "linear", "one_sided"] = "two_sided"
    folds: Fraction | None = None


FORCES = Interval(ge=0.0, le=1.0)


@dataclass(frozen=True)
class Force(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[Newtons, FORCES]
    low: Annotated[Newtons, FORCES] = 0.0


@dataclass(frozen=True)
class Stiction:
    """Connections between close strands until they are pulled apart: Sec. 5.2, in physical terms.

    reach    distance at which segments connect, and rest length of the connection
    release  distance at which a connection breaks
    force    force of a connection at release; of two segments of different forces their geometric mean
    closest  maximum number of connections of a segment
    damping  damping of a connection, as a fraction of critical damping
    """

    reach: Annotated[Metres, Interval(gt=1e-6, le=0.05)] = 5e-4
    release: Annotated[Metres, Interval(gt=1e-6, le=0.1)] = 1.5e-3
    force: Force = Force(2e-5)
    closest: Annotated[int, Interval(ge=1, le=16)] = 5
    damping: Annotated[float, Ge(0.0)] = 0.5

    def __post_init__(self) -> None:
        if not self.release > self.reach:
            what = f"the release distance, {self.release:g} m, is not more than the reach, {self.reach:g} m"
            raise BadInput(what, right="a larger release, or a smaller reach")


@dataclass(frozen=True)
class Thickness(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[Metres, Interval(ge=1e-6, le=0.02)]
    low: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 0.0


@dataclass(frozen=True)
class Collisions:
    """Repulsion between strands, without penetration.

    thickness  distance kept between the axes of two strands; of two segments of different thickness their mean
    friction   Coulomb friction coefficient between strands
    stiffness  contact stiffness of two strands; a lower one is faster, but yields under tens of strands
    solver     contact solver: coupled (one system with the strands, needed for stacks), or sweep (published impulses
               pair by pair; with schemes other than nine_steps they act once, on the final velocities, and add energy)
    sweeps     number of sweeps over all pairs, for the solver `sweep`
    attempts   maximum number of passes per step to resolve crossings; what few then still cross move as one
    """

    thickness: Thickness = Thickness(3e-4)
    friction: Annotated[float, Ge(0.0)] = 0.3
    stiffness: Annotated[NewtonsPerMetre, Interval(gt=0.0, le=1e4)] = 0.1
    solver: Literal["coupled", "sweep"] = "coupled"
    sweeps: Annotated[int, Interval(ge=1, le=100)] = 3
    attempts: Annotated[int, Interval(ge=1, le=1000)] = 50


@dataclass(frozen=True)
class Pressure:
    """Repulsion of hair that is denser than a limit.

    density     maximum density of hair; by default the maximum of the groom, which then keeps its shape
    compliance  ratio of excess density to pressure
    """

    density: Annotated[KilogramsPerCubicMetre, Gt(0.0)] | None = None
    compliance: Annotated[SecondsSquaredPerMetreSquared, Interval(ge=0.0, le=100.0)] = 0.1


@dataclass(frozen=True)
class Target:
    """Attraction of hair to a given density: another simulation's, a groom's or a file's.

    The target is scaled to the total length of the hair, so that one of fewer strands or in another unit has the same
    effect.

    cell    cell size of the finest grid
    levels  number of grids, each of twice the cell size of the previous; coarse ones attract distant hair
    rate    natural frequency of hair about its target
    """

    cell: Annotated[Metres, Interval(ge=5e-4, le=0.2)] = 0.012
    levels: Annotated[int, Interval(ge=1, le=6)] = 5
    rate: Annotated[PerSecond, Interval(gt=0.0, le=1e4)] = 30.0


@dataclass(frozen=True)
class Volume:
    """Hair as one material on a grid, after Petrovic, Henne, Anderson 2005.

    Strands slow each other down and resist compression without a search for pairs. The model forms no locks, and
    strands may cross.

    cell       spacing of the grid nodes
    friction   relaxation rate of a strand's velocity to that of the hair around it
    order      order of damping: 1 damps all deviations from the local mean, 2 only those that vary from strand to
               strand
    smoothing  number of smoothing passes over the grid; eight equal one at twice the cell size
    pressure   pressure that resists compression; if absent, density has no limit
    target     attraction to the density `in.target`; if absent, there is none
    """

    cell: Annotated[Metres, Interval(ge=5e-4, le=0.2)] = 0.006
    friction: Annotated[PerSecond, Interval(ge=0.0, le=1e5)] = 120.0
    order: Annotated[int, Interval(ge=1, le=2)] = 1
    smoothing: Annotated[int, Interval(ge=0, le=8)] = 1
    pressure: Pressure | None = None
    target: Target | None = None


@dataclass(frozen=True)
class Locks:
    """One simulation for strands that move together.

    Strands with lasting connections of stiction form a lock. One of them is simulated, its guide, with contact
    distances for the number of its strands; the others, its followers, are interpolated from neighbouring guides while
    these agree.

    after      number of frames that a connection has to last before it counts
    part       minimum share of segments with lasting connections between two strands in one lock
    most       maximum number of strands in a lock
    tolerance  largest error of a follower; a strand is simulated again if its guides disagree by more, or a body
               displaces it farther, until interpolation has been within it for `after` frames
    audit      share of locks simulated in full, in turn, to measure the error: at least two of eight or more, of which
               only those in motion; locks with errors over `tolerance` dissolve; 0 switches it off
    """

    after: Annotated[int, Interval(ge=1, le=10_000)] = 5
    part: Annotated[float, Interval(gt=0.0, le=5.0)] = 0.5
    most: Annotated[int, Interval(ge=2, le=100_000)] = 16
    tolerance: Annotated[Metres, Interval(gt=0.0, le=1.0)] = 4e-3
    audit: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.02


@dataclass(frozen=True)
class StrainLimit:
    """Limit of the stretch of a segment at the end of a step.

    tolerance  maximum strain of a segment
    """

    tolerance: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.02


@dataclass(frozen=True)
class StepControl:
    """Limits that divide a frame into steps.

    longest      maximum duration of a step
    root         maximum displacement of a root per step; 1 cm in the authors' code
    travel       maximum displacement of a particle or body per step; larger displacements stretch hair
    strain_rate  maximum strain increment of an edge per step; 0.1 in the authors' code
    courant      maximum ratio of the step to the stability limit of an explicit step; 4 and 10 in the authors' code
    crossings    maximum number of possible crossings per segment and step; more of them shorten the step, down to a
                 quarter of `longest`
    most         maximum number of steps per frame; a shot that needs more stops and reports the strand and the limit
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
    """Time integration of a step.

    value         time integrator: tr_bdf2 (two solves, second order), bdf2 (one, second order), backward_euler (one,
                  first order), nine_steps (as published)
    spring        implicit part of a spring force: multiplier (tension of the previous solve), tension (tension of the
                  present strain), printed (along the spring only), explicit (damping only)
    velocity      velocity update of nine_steps: trapezoid as printed, full_step as in the authors' code
    overdamping   ratio of spring damping to critical damping; 40 in the authors' code
    iterations    number of Newton iterations per solve
    guard         strain that triggers a re-solve: a predicted edge strain beyond it restarts the solve from the
                  previous state, or with forces between strands, from the backward Euler solution without them
    """

    value: Literal["tr_bdf2", "bdf2", "backward_euler", "nine_steps"] = "tr_bdf2"
    spring: Literal["multiplier", "tension", "printed", "explicit"] = "multiplier"
    velocity: Literal["trapezoid", "full_step"] = "trapezoid"
    overdamping: Annotated[float, Ge(0.0)] = 0.0
    iterations: Annotated[int, Interval(ge=1, le=20)] = 1
    guard: Annotated[float, Gt(0.0)] = 0.03


@dataclass(frozen=True)
class Share(Varied):
    __doc__ = Varied.__doc__
    value: Fraction
    low: Fraction = 0.0


@dataclass(frozen=True)
class Rest:
    """Shape of hair at rest, without a load, and the shape in which it begins.

    shape     share of the curvature of the groom at rest: 1 (the groom), 0 (straight hair), in between linearly, also
              along a strand
    balanced  share of its weight that a strand bears in the shape of the groom, by a rest shape bent against gravity: 0
              (hair sags from the groom), 1 (the groom is in equilibrium)
    start     shape at the first frame: groomed, or settled (the equilibrium of the rest shape under gravity)
    unstable  treatment of balanced strands without a stable equilibrium in the shape of the groom: fall (from there),
              settle (start in the sagged shape), refuse (stop with a message)
    strain    maximum strain of a spring in a balanced strand; more marks the strand as unstable
    """

    shape: Share = Share(1.0)
    balanced: Share = Share(0.0)
    start: Literal["groomed", "settled"] = "groomed"
    unstable: Literal["fall", "settle", "refuse"] = "fall"
    strain: Annotated[float, Interval(gt=0.0, le=1.0)] = 0.3

    def __post_init__(self) -> None:
        if self.balanced.profile:
            what = "balanced varies along strands, which bear their weight as a whole"
            raise BadInput(what, where="balanced.profile", right="a map, an image or groups")
        if self.shape.is_constant and self.balanced.is_constant:
            check_rest(self.shape.value < 1.0 and self.balanced.value > 0.0, "all strands")

    @property
    def in_equilibrium(self) -> bool:
        """Whether hair, or some of it, begins in equilibrium."""
        return self.start == "settled" or self.balanced != Share(0.0)


def check_rest(contradicts: bool, strands: str) -> None:
    """Raise BadInput, which names the strands, where hair that is straighter than the groom should be balanced."""
    if contradicts:
        what = f"shape below 1 contradicts balanced, whose rest shape is that which holds the groom up: {strands}"
        raise BadInput(what, where="rest", right="balanced = 0, or shape = 1")


@dataclass(frozen=True)
class Construction:
    """The lattice of a strand and its springs, for experiments with their parts.

    turn           angle of the perturbed particles about the axis from segment to segment, reversed every five; 0
                   leaves the network floppy, 90 puts two altitude springs at rest in one place
    off_axis_mass  share of the mass on the perturbed particles; the published third slows torsion
    bending        factor on the bending constant of the material; 0 removes the bending springs
    torsion        factor on the torsion constant of the material; 0 removes the torsion springs
    altitude       ratio of the altitude constant to the torsion constant; 0 lets long hair collapse
    """

    turn: Annotated[Degrees, Interval(ge=0.0, le=180.0)] = 72.0
    off_axis_mass: Annotated[float, Interval(gt=0.0, le=0.5)] = 0.05
    bending: Annotated[float, Ge(0.0)] = 1.0
    torsion: Annotated[float, Ge(0.0)] = 1.0
    altitude: Annotated[float, Interval(ge=0.0, le=10.0)] = 0.4
