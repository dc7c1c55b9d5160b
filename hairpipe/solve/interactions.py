"""Interactions: the protocol that wind, bodies, hair contact and user-defined forces implement.

An interaction receives the points of strand axes, never the particles. The hooks are called in this order in a step:

    begin          prepare at the start of the step
    predict        a stage begins: query its predicted end                  }
    linearise      add force and damping at the prediction                  }  every stage; linearise and judge
    couple         set the couplings between strands                        }  again for strands marked by judge
    judge          mark points whose strands must be solved again           }
    finish_solves  the solves of the step are over
    repel          change velocities by impulses
    limit          keep positions of particles within bounds
    correct        correct the errors that the solves left or do not model

All hooks do nothing unless overridden, so a force needs `linearise` alone:

    class Spring(Interaction):
        def linearise(self, at, push, damping):
            h = at.weights[-1]
            push[-1] += K * (self.place(at.seconds) - at.points[-1] + h * at.velocities[-1])
            damping[-1, [0, 3, 5]] += K * h

Pass user-defined interactions to a simulation by `with_interactions(scene, ...)`; `shot/build.py` defines the order.
"""

from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from hairpipe.geometry.simd import combine_all, copied
from hairpipe.solve.couplings import NOWHERE, Couplings, Places
from hairpipe.strands.layout import Axis, follow
from hairpipe.values.hair import HairState


class Start(NamedTuple):
    """Points at the start of a step.

    points, velocities  in the world [m], [m/s], (P, 3)
    masses              inf for held points [kg], (P,)
    time                time since the previous frame [s]
    seconds             time of the shot [s]
    dt                  duration of the step [s]
    """

    points: np.ndarray
    velocities: np.ndarray
    masses: np.ndarray
    time: float
    seconds: float
    dt: float


class Prediction(NamedTuple):
    """Points at the linearisation of a stage, or after one of its solves; passed whole to kernels.

    points, velocities  in the world [m], [m/s], (P, 3)
    lagged_velocity     velocity for drag and friction: at the start of the stage, then of the last solve [m/s], (P, 3)
    masses              inf for held points [kg], (P,)
    weights             weight h of the end of the stage: x = xh + h v [s], (P,)
    active              points of strands to solve, (P,) bool; the others are ignored
    span                duration of the stage [s]
    time                end of the stage since the previous frame (in nine_steps, a time within it) [s]
    seconds             the same time in the shot [s]
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
    before   positions at the start of the step, same shape
    masses   masses of points, inf if held [kg], (P,)
    axis     location of the points among the particles
    origin   [m], (3,)
    time     start of the step since the previous frame [s]
    dt       duration of the step [s]
    moved    whether corrections have moved points
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
    moved: bool = field(default=False, init=False)

    @property
    def points(self) -> np.ndarray:
        """Current positions of points in the world [m], (P, 3)."""
        return self.axis.gather(self.x, origin=self.origin)

    @property
    def points_before(self) -> np.ndarray:
        """Positions of points at the start of the step, in the world [m], (P, 3)."""
        return self.axis.gather(self.before, origin=self.origin)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of points [m/s], (P, 3)."""
        return self.axis.gather(self.v)

    def move(self, change: np.ndarray, times: float = 1.0) -> None:
        """Move points by so many times (P, 3) [m], with the particles off the axis; held ones stay."""
        self.moved = True
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
    """An interaction with strands; hooks are called as the module states, and do nothing here.

    in_solve  whether it acts in solves; otherwise it only corrects their results
    couples   whether it couples strands: `places` and `couple` are then called
    """

    in_solve: ClassVar[bool] = True
    couples: ClassVar[bool] = False

    def begin(self, start: Start) -> None:
        """Prepare for a step at its start."""

    def leave_to_corrections(self) -> None:
        """Hold nothing in the solves of this step but what `correct` finds: the nine steps."""

    def predict(self, at: Prediction) -> None:
        """Evaluate the prediction of a stage."""

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the force push - damping v, linearised at a prediction, in place.

        push [N], (P, 3); damping  symmetric, xx xy xz yy yz zz, not negative [kg/s], (P, 6)

        A stiffness K belongs to both, since points end at x + h (v - v_predicted): damping += h K.
        """

    @property
    def places(self) -> Places:
        """Pairs of segments that this step couples, known after `begin`; none by default."""
        return NOWHERE

    def couple(self, at: Prediction, couplings: Couplings) -> None:
        """Set which of `places` act, and what they exert, linearised at a prediction, in place."""

    def judge(self, at: Prediction, again: np.ndarray) -> None:
        """Check the result of a solve; mark points whose strands must be solved again, (P,) bool, in place."""

    def finish_solves(self, end: StepEnd) -> None:
        """Remove velocities that solves added only to hold points, and free memory of the solves."""

    def repel(self, end: StepEnd, *, elastic: bool) -> None:
        """Change velocities by impulses, in place; elastic: undo overlaps too."""

    def limit(self, x: np.ndarray, held: np.ndarray, excess: float = 0.0) -> None:
        """Keep positions of particles [m], (rows, 3, W), within 1 + excess of bounds, in place; held as in `Step`."""

    def correct(self, end: StepEnd) -> None:
        """Correct positions and velocities at the end of a step, in place."""

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
