"""What acts on strands: the protocol that wind, bodies, other hair and forces of your own implement.

An interaction sees the points of strands' axes, never their particles. In a step it is called in this order:

    begin          look around where the step begins
    predict        a stage begins: look where it is predicted to end        }
    linearise      add force and damping at the prediction                  }  every stage; linearise and judge
    couple         set what joins strands to each other                     }  again where judge asked for it
    judge          mark points whose strands must be solved again           }
    finish_solves  the solves of the step are over
    repel          change velocities by impulses
    limit          keep positions of particles within bounds
    correct        put right what the solves left, or never saw

All hooks do nothing unless overridden, so a force needs `linearise` alone:

    class Spring(Interaction):
        def linearise(self, at, push, damping):
            h = at.weights[-1]
            push[-1] += K * (self.place(at.seconds) - at.points[-1] + h * at.velocities[-1])
            damping[-1, [0, 3, 5]] += K * h

Hand interactions of your own to a simulation by `with_interactions(scene, ...)`; `sim/build.py` decides the order.
"""

from dataclasses import dataclass, field, fields
from typing import ClassVar, NamedTuple

import numpy as np

from hairpipe.data.hair import HairState
from hairpipe.kernels.simd_arrays import combine_all, copied
from hairpipe.sim.axis import Axis, follow, gather
from hairpipe.sim.contact.hair.couplings import Couplings, Places
from hairpipe.sim.settings import Scene


class Start(NamedTuple):
    """Points where a step begins.

    points, velocities  in the world [m], [m/s], (P, 3)
    masses              inf where they are held [kg], (P,)
    time                since the previous frame [s]
    seconds             of the shot [s]
    dt                  that the step lasts [s]
    """

    points: np.ndarray
    velocities: np.ndarray
    masses: np.ndarray
    time: float
    seconds: float
    dt: float


class Prediction(NamedTuple):
    """Points where a stage is linearised, or where a solve of it has led; travels whole into kernels.

    points, velocities  in the world [m], [m/s], (P, 3)
    lagged_velocity     that drag and friction go by: of how the stage began, then of the last solve [m/s], (P, 3)
    masses              inf where points are held [kg], (P,)
    weights             h, of the end of the stage: x = xh + h v [s], (P,)
    active              points of strands that are solved, (P,) bool; nothing is asked of the others
    span                that the stage covers [s]
    time                of the stage, at its end but in the nine steps, since the previous frame [s]
    seconds             the same in the shot [s]
    """

    points: np.ndarray
    velocities: np.ndarray
    lagged_velocity: np.ndarray
    masses: np.ndarray
    weights: np.ndarray
    active: np.ndarray
    span: float
    time: float
    seconds: float


@dataclass(eq=False)
class StepEnd:
    """Strands after the solves of a step, which interactions correct.

    x, v     positions about the origin [m] and velocities [m/s], (rows, 3, W); changed in place
    before   positions where the step began, same shape
    masses   of points, inf where they are held [kg], (P,)
    axis     where points lie among particles
    origin   [m], (3,)
    time     at which the step began, since the previous frame [s]
    dt       that it lasted [s]
    """

    x: np.ndarray
    v: np.ndarray
    before: np.ndarray
    masses: np.ndarray
    axis: Axis
    origin: np.ndarray
    time: float
    dt: float
    _solved: np.ndarray | None = field(default=None, init=False)

    @property
    def points(self) -> np.ndarray:
        """Where points are now, in the world [m], (P, 3)."""
        return points_at(self.axis, self.x) + self.origin

    @property
    def points_before(self) -> np.ndarray:
        """Where points began the step, in the world [m], (P, 3)."""
        return points_at(self.axis, self.before) + self.origin

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of points [m/s], (P, 3)."""
        return points_at(self.axis, self.v)

    def move(self, change: np.ndarray, times: float = 1.0) -> None:
        """Move points by so many times (P, 3) [m], with the particles off the axis; held ones stay."""
        follow(self.axis, change, times, self.x)

    def push(self, change: np.ndarray) -> None:
        """Change velocities of points by (P, 3) [m/s], with those of particles off the axis."""
        if self._solved is None:
            self._solved = copied(self.v)
        follow(self.axis, change, 1.0, self.v)

    def pushed(self) -> np.ndarray | float:
        """Return the change of velocity by all pushes [m/s], (rows, 3, W), or 0; nothing is pushed after that."""
        if self._solved is None:
            return 0.0
        combine_all(self._solved, 1.0, self.v, -1.0, self._solved)
        return self._solved


class Interaction:
    """One thing that acts on strands; its hooks are called as the module says, and do nothing here.

    in_solve  whether it takes part in solves; else it only puts right what they leave
    couples   whether it joins strands to each other: `places` and `couple` are asked for
    """

    in_solve: ClassVar[bool] = True
    couples: ClassVar[bool] = False

    def begin(self, start: Start) -> None:
        """Look around at the start of a step."""

    def leave_to_corrections(self) -> None:
        """Hold nothing in the solves of this step but what `correct` finds: the nine steps."""

    def predict(self, at: Prediction) -> None:
        """Look where a stage is predicted to end."""

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the force push - damping v, linearised at a prediction, in place.

        push [N], (P, 3); damping  symmetric, xx xy xz yy yz zz, not negative [kg/s], (P, 6)

        A stiffness K belongs to both, since points end at x + h (v - v_predicted): damping += h K.
        """

    @property
    def places(self) -> Places:
        """Pairs of segments that this step couples, known after `begin`."""
        raise NotImplementedError

    def couple(self, at: Prediction, couplings: Couplings) -> None:
        """Set which of `places` act, and what they exert, linearised at a prediction, in place."""

    def judge(self, at: Prediction, again: np.ndarray) -> None:
        """Look at what a solve found; mark points whose strands must be solved again, (P,) bool, in place."""

    def finish_solves(self, end: StepEnd) -> None:
        """Take back what solves gave velocities only to hold points, and free what only solves need."""

    def repel(self, end: StepEnd, *, elastic: bool) -> None:
        """Change velocities by impulses, in place; elastic: undo overlaps too."""

    def limit(self, x: np.ndarray, held: np.ndarray) -> None:
        """Keep positions of particles [m], (rows, 3, W), within bounds, in place; held as in `Step`."""

    def correct(self, end: StepEnd) -> None:
        """Put positions and velocities right at the end of a step, in place."""

    def mark_discontinuous(self, marked: np.ndarray) -> None:
        """Mark points whose forces jumped in this step, (P,) bool, in place: their strands restart."""

    def remember(self, state: HairState) -> HairState:
        """Return the state with what the next frame must know; pure."""
        return state

    @property
    def speed_bound(self) -> float:
        """Speed of what hair may meet, which bounds the step [m/s]."""
        return 0.0

    def stiffness_bound(self, masses: np.ndarray) -> float:
        """Bound what this adds to the square of the highest frequency [1/s^2], for an explicit step."""
        return 0.0

    @property
    def crossed(self) -> float:
        """Pairs a segment that the last step had to keep from passing through each other."""
        return 0.0


def points_at(axis: Axis, lanes: np.ndarray) -> np.ndarray:
    """Return what particles on the axis have, (rows, 3, W), for every point, (P, 3) float64; pure."""
    points = np.empty((axis.offsets[-1], lanes.shape[1]))
    gather(axis, np.ones(axis.strands.shape, lanes.dtype), lanes, points)
    return points


@dataclass(frozen=True)
class ExtendedScene(Scene):
    """A scene with interactions of your own, which no graph file has."""

    interactions: tuple[Interaction, ...] = ()


def with_interactions(scene: Scene, *interactions: Interaction) -> ExtendedScene:
    """Return the scene with interactions of your own besides its; pure."""
    said = {each.name: getattr(scene, each.name) for each in fields(Scene)}
    return ExtendedScene(**said, interactions=(*own_interactions(scene), *interactions))


def own_interactions(scene: Scene) -> tuple[Interaction, ...]:
    """Return the interactions of a scene that are none of the house's."""
    return scene.interactions if isinstance(scene, ExtendedScene) else ()
