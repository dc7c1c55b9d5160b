"""The interactions of a frame, driven by an integrator: begin a step, solve stages, correct, bound the step.

Interactions are accessed only by the protocol, see `interactions.py`. They are called in the given order, except in
`end`, the corrections at the end of a step, which runs in reverse: the first interaction corrects last.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hairpipe.geometry.simd import copied
from hairpipe.solve.conjugate_gradients import StrandCoupling
from hairpipe.solve.interactions import Interaction, Start, StepEnd
from hairpipe.solve.stage import Iterate, Rule, Stage, State, Step
from hairpipe.solve.stage_driver import StageDriver
from hairpipe.solve.stretch import mark_length_jumps
from hairpipe.strands.interface import StrandModel
from hairpipe.strands.layout import Axis, Layout, axis_of
from hairpipe.values.hair import HairState


@dataclass(eq=False)
class Surroundings:
    """The interactions of strands in a frame.

    model, layout  those of the strands
    interactions   in order, see above
    seconds        time of the shot at the previous frame [s]
    origin         origin of strand positions [m], (3,); interactions receive points in the world
    speed          factor on the speed of what rests, where strands are coupled [1]
    """

    model: StrandModel
    layout: Layout
    interactions: Sequence[Interaction] = ()
    seconds: float = 0.0
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))
    speed: float = 1.0
    _axis: Axis = field(init=False)
    _masses: np.ndarray = field(init=False)
    _driver: StageDriver = field(init=False)
    _jumped: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self._axis = axis_of(self.layout)
        self._masses = self._axis.gather(self.model.mass[:, None, :])[:, 0]
        self._masses[self.layout.offsets[:-1]] = np.inf
        acting = [interaction for interaction in self.interactions if interaction.in_solve]
        coupling = StrandCoupling([interaction for interaction in acting if interaction.couples], self.speed)
        frame = self.origin, self.seconds
        self._driver = StageDriver(self.model, self._axis, self._masses, acting, coupling, *frame)
        self._jumped = np.zeros(self.layout.strands.shape, self.layout.dtype)

    def begin(self, state: State, step: Step) -> None:
        """Prepare interactions at the start of a step."""
        self._hold_tips(step.held)
        if self._driver.interactions:
            points = self._axis.gather(state.x, origin=self.origin)
            velocities = self._axis.gather(state.v)
            start = Start(points, velocities, self._masses, step.time, self.seconds + step.time, step.dt)
            for interaction in self._driver.interactions:
                interaction.begin(start)
            if self._driver.coupling:
                self._driver.coupling.begin(len(points))

    def _hold_tips(self, held: np.ndarray) -> None:
        """Exclude the last segments of strands with a held tip, (blocks, W), from all motion."""
        if len(held):
            marked = self._axis.gather(held, np.empty(len(self._masses), np.bool_))
            last = self.layout.offsets[1:] - 1
            last = last[marked[last]]
            self._masses[last] = self._masses[last - 1] = np.inf

    def leave_to_corrections(self) -> None:
        """Release all points that interactions hold in the solves of this step, except those of `correct`."""
        for interaction in self.interactions:
            interaction.leave_to_corrections()

    def solve(
        self, x: np.ndarray, v: np.ndarray, T: np.ndarray, stage: Stage, rule: Rule, active: np.ndarray | None = None
    ) -> np.ndarray | float:
        """Advance strands through a stage, in place, see `StageDriver.solve`; v is the guess."""
        return self._driver.solve(Iterate(x, v, T), stage, rule, active)

    def limit_velocity(self, x: np.ndarray, v: np.ndarray, step: Step) -> None:
        """Change v so that x + dt v keeps all limits, in place; x, v (rows, 3, W)."""
        target = x + step.dt * v
        limited = target.copy()
        for interaction in self.interactions:
            interaction.limit(limited, step.held)
        v += (limited - target) / step.dt

    def repel(self, x: np.ndarray, v: np.ndarray, step: Step, *, elastic: bool) -> None:
        """Apply the impulses of interactions to velocities, in place; x, v (rows, 3, W)."""
        end = self._end_of(x, v, x, step)
        for interaction in self.interactions:
            interaction.repel(end, elastic=elastic)

    def correct(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, step: Step) -> None:
        """Apply the corrections of interactions in order, in place.

        x, v, before  positions and velocities now, positions at the start of the step, (rows, 3, W)
        """
        end = self._end_of(x, v, before, step)
        for interaction in self.interactions:
            interaction.correct(end)

    def end(self, state: State, before: np.ndarray, step: Step) -> np.ndarray | float:
        """Correct the result of the solves of a step, in place; before: positions at its start [m], (rows, 3, W).

        Velocities first, in order: velocities that only enforced positions are removed, and close hair repels. Then
        positions, in reverse order.

        Returns the change of velocities [m/s], (rows, 3, W), or 0.
        """
        self._jumped[:] = 0.0
        if not self.interactions:
            return 0.0
        if self._driver.coupling:
            self._driver.coupling.release()
        end = self._end_of(state.x, state.v, before, step)
        for interaction in self.interactions:
            interaction.finish_solves(end)
        for interaction in self.interactions:
            interaction.repel(end, elastic=True)
        solved = copied(state.x)
        for interaction in reversed(self.interactions):
            interaction.limit(state.x, step.held)
            interaction.correct(end)
        mark_length_jumps(self.model, solved, state.x, self._jumped)
        return end.pushed()

    def discontinuous(self, like: np.ndarray) -> np.ndarray:
        """Mark the strands whose forces jumped in this step, (blocks, W), in the dtype of an array.

        Interactions report it, or `end` stretched or relieved hairs.
        """
        marked = np.zeros(len(self._masses), np.bool_)
        lanes = np.zeros(self.layout.strands.shape, like.dtype)
        for interaction in self.interactions:
            interaction.mark_discontinuous(marked)
        self._axis.scatter(marked, lanes)
        return np.maximum(lanes, self._jumped)

    def remember(self, state: HairState) -> HairState:
        """Return the state with what interactions must know in the next frame; pure."""
        for interaction in self.interactions:
            state = interaction.remember(state)
        return state

    def fastest(self) -> float:
        """Find a speed that nothing exceeds which hair may meet in this frame [m/s]."""
        return max((interaction.speed_bound for interaction in self.interactions), default=0.0)

    def stiffness(self) -> float:
        """Bound what interactions add to the square of the highest frequency [1/s^2]."""
        return sum((interaction.stiffness_bound(self._masses) for interaction in self.interactions), 0.0)

    @property
    def crossed(self) -> float:
        """Pairs a segment that the last step had to keep from passing through each other."""
        return max((interaction.crossed for interaction in self.interactions), default=0.0)

    def _end_of(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, step: Step) -> StepEnd:
        return StepEnd(x, v, before, self._masses, self._axis, self.origin, step.time, step.dt)
