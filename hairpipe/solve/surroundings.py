"""The interactions of a frame, driven by an integrator: begin a step, solve stages, correct, bound the step.

Interactions are accessed only by the protocol, see `interactions.py`. They are called in the given order, except in
`end`, the corrections at the end of a step, which runs in reverse: the first interaction corrects last.

A stage without interactions is one kernel. Otherwise all strands are solved together from their prediction
(`guess_stages`), judged, and solved again where an interaction requests it: where contact changed. Couplings make one
system of all strands, solved by conjugate gradients preconditioned by the strands' own factors; strands that are
solved again use the resulting positions of the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit, prange
from numpy.typing import DTypeLike

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import both, copied, fill, load, select, store
from hairpipe.solve.band import forward, row_size, substitute
from hairpipe.solve.conjugate_gradients import StrandCoupling
from hairpipe.solve.implicit_stage import (
    ROWS,
    ROWS_WITH_NEXT,
    ExternalTerms,
    add_impulses,
    clear,
    factor_stages,
    find_overturned,
    guess_stages,
    lay_out,
    run_stages,
    set_contact_dv,
    update_stages,
)
from hairpipe.solve.interactions import Interaction, Prediction, Start, StepEnd
from hairpipe.solve.stage import Iterate, Rule, Stage, State, Step, System
from hairpipe.solve.stretch import STRETCH, mark_length_jumps
from hairpipe.strands.interface import StrandModel, shape_of
from hairpipe.strands.layout import Axis, Layout, axis_of
from hairpipe.values.hair import HairState


@njit(cache=True, parallel=True)
def respond(model, axis: Axis, system, held, active, impulses, change) -> None:
    """Solve every strand's own system for impulses on its axis, in place.

    system    A: factors of `factor_stages`, in single precision since reading them dominates the time
              b: the change of all particles is added to it [m/s], (rows, unknowns, W); skipped if it has no rows
    held      see `Step`
    active    1 for strands to solve, (blocks, W); the others do not move
    impulses  [N s], (P, 3)
    change    out: change of the velocity of points [m/s], (P, 3)
    """
    for block in prange(len(axis.first) - 1):
        _respond_block(model, axis, np.int64(block), system, held, active, impulses, change)


@njit(cache=True, error_model="numpy")
def _respond_block(model, axis, block, system, held, active, impulses, change):
    rows = slice(axis.first[block], axis.first[block + 1])
    As = system.A[rows]
    b = system.b
    x = np.empty((As.shape[0], shape_of(model).unknowns, As.shape[2]), active.dtype)
    count = x.shape[0]
    clamped = shape_of(model).clamped
    fill(x, 0.0)
    if active[block].any():
        _take(axis, block, impulses, x)
        for p in range(clamped):  # The root is held: impulses on it are taken by the body.
            for c in range(3):
                store(x, (p, c), 0.0)
        for p in range(clamped, count):
            # Cleared just before the row is eliminated, so that an impulse on a held particle reaches no later row.
            free = load(active, (block,)) > 0.0
            if len(held) > 0 and p >= count - clamped:
                free = both(free, load(held, (block,)) < 0.5)
            for c in range(3):
                store(x, (p, c), select(free, load(x, (p, c)), 0.0))
            forward(model, As, x, p, count)
        substitute(model, As, x, count)
        if b.shape[0] > 0:
            bs = b[rows]
            for p in range(count):
                for c in range(shape_of(model).unknowns):
                    store(bs, (p, c), load(bs, (p, c)) + load(x, (p, c)))
    _give(axis, block, x, change)


@inlined
def _take(axis, block, points, x):
    """Copy what points of a block have to its particles."""
    for lane in range(axis.strands.shape[1]):
        first = axis.offsets[axis.strands[block, lane]]
        row = axis.root
        for k in range(first, axis.offsets[axis.strands[block, lane] + 1]):
            for c in range(3):
                x[row, c, lane] = points[k, c]
            row += axis.stride


@inlined
def _give(axis, block, x, points):
    """Copy what particles of a block have to its points."""
    for lane in range(axis.strands.shape[1]):
        if not axis.idle[block, lane]:  # An idle lane repeats a strand: its points are written once only.
            first = axis.offsets[axis.strands[block, lane]]
            row = axis.root
            for k in range(first, axis.offsets[axis.strands[block, lane] + 1]):
                for c in range(3):
                    points[k, c] = x[row, c, lane]
                row += axis.stride


_PASSES = 4  # over the strands that must be solved again


@dataclass(eq=False)
class StageDriver:
    """Solves stages of a frame.

    model         model of the strands
    axis          location of the points among the particles
    masses        masses of points, inf if held [kg], (P,); may change between steps
    interactions  interactions that act in solves, in order
    coupling      coupling of strands by those that couple them
    origin        origin of strand positions [m], (3,)
    seconds       time of the shot at the previous frame [s]
    """

    model: StrandModel
    axis: Axis
    masses: np.ndarray
    interactions: Sequence[Interaction]
    coupling: StrandCoupling
    origin: np.ndarray
    seconds: float
    _memory: dict[str, np.ndarray] = field(default_factory=dict, init=False)

    def solve(self, at: Iterate, stage: Stage, rule: Rule, active: np.ndarray | None = None) -> np.ndarray | float:
        """Advance strands through a stage, in place.

        at      in: its v is the guess; out: the end of the stage
        active  1 for strands to solve individually, (blocks, W); None: all, together

        Returns the change of velocity by other strands, excluded from the acceleration [m/s], (rows, 3, W), or 0.
        """
        together = active is None
        if not self.interactions and together:
            run_stages(self.model, at, stage, rule)
            return 0.0
        guess_stages(self.model, at, stage, rule)
        everyone = np.ones(self.axis.strands.shape, at.x.dtype)
        again = active = everyone if active is None else active
        here = self._predict(at, stage, active)
        contact_dv = self._room("contact_dv", here.points)
        if not together:  # Else all points are set.
            contact_dv[:] = 0.0
        for interaction in self.interactions:
            interaction.predict(here)
        for left in reversed(range(rule.iterations + _PASSES)):
            newton = left >= _PASSES  # After that, passes for strands whose contact changed, each by itself.
            self.axis.gather(again, here.active)
            outer = self._act(here, stage, again, at.x, renew=newton)
            b = self._solve_once(at, stage, rule, outer, again, coupled=newton and together)
            if self.coupling:
                change, received = self._room("change", here.points), self._room("received", here.points)
                self.axis.gather(b, change, active=again)
                self.coupling.follow(change, here.active, received)
                set_contact_dv(here.active, received, self.masses, contact_dv)
            update_stages(self.model, at, b, again, stage.h, rule)
            self.axis.gather(at.x, here.points, active=again, origin=self.origin)
            self.axis.gather(at.v, here.velocities, active=again)
            here = here._replace(lagged_velocity=here.velocities)  # Newer than where the stage began.
            wrong = self._judge(here, at.x.dtype) * active
            again = active if left > _PASSES else wrong
            if not again.any():
                break
        return self._spread(contact_dv, at.x)

    def _predict(self, at: Iterate, stage: Stage, active: np.ndarray) -> Prediction:
        """Return where strands are predicted to end a stage; active is 1 for strands that are solved, (blocks, W)."""
        points = self.axis.gather(at.x, origin=self.origin)
        velocities = self.axis.gather(at.v)
        lagged = velocities if stage.began is at.v else self.axis.gather(stage.began)
        weights = self.axis.gather(stage.h)
        active_points = self.axis.gather(active, np.empty(len(self.masses), np.bool_))
        times = stage.span, stage.time, self.seconds + stage.time
        return Prediction(points, velocities, lagged, self.masses, weights, active_points, *times)

    def _act(self, here: Prediction, stage: Stage, active: np.ndarray, like: np.ndarray, *, renew: bool) -> np.ndarray:
        """Return external terms of active strands, (blocks, W); see `implicit_stage.py`.

        renew  linearise forces between strands again; else those of previous solves are used
        """
        push = self._room("push", here.points)
        damping = self._room("damping", here.points, 6)
        clear(here.active, push, damping)
        for interaction in self.interactions:
            interaction.linearise(here, push, damping)
        received = push[:0]
        own = (np.empty((0, 6), np.float32), np.empty((0, 6), np.float32))
        if self.coupling:
            received = self._room("received", here.points)
            if renew:
                self.coupling.linearise(here)
            self.coupling.impulses(here.active, received)
            own = self.coupling.own
        rows = ROWS_WITH_NEXT if self.coupling else ROWS
        outer = self._room("outer", like[:: self.axis.stride], rows)
        lay_out(self.axis, active, ExternalTerms(push, damping, received, *own), here.velocities, stage.h, outer)
        return outer

    def _solve_once(
        self, at: Iterate, stage: Stage, rule: Rule, outer: np.ndarray, active: np.ndarray, *, coupled: bool
    ) -> np.ndarray:
        """Return the change of velocity of active strands, (blocks, W) [m/s], (rows, 3, W).

        coupled  whether all form one system; otherwise the other strands are fixed
        """
        coupled = coupled and bool(self.coupling)
        factors = outer[:0].astype(np.float32)  # No rows: factors are not kept where nothing couples strands.
        if coupled:
            factors = self._room("factors", at.x, row_size(self.model.shape), np.float32)
        b = self._room("b", at.x, self.model.shape.unknowns)
        firm = active.copy()
        factor_stages(self.model, System(factors, b), at, outer, firm, stage, rule)
        if not coupled:
            return b

        def ask(impulses: np.ndarray, change: np.ndarray) -> None:
            respond(self.model, self.axis, System(factors, b[:0]), stage.held, active, impulses, change)

        alone = self._room("alone", self.masses)
        unused = np.empty_like(alone, np.float32)
        again = False
        while True:
            self.axis.gather(b, alone)
            exchanged = self.coupling.exchange(ask, alone, self.masses)
            respond(self.model, self.axis, System(factors, b), stage.held, active, exchanged, unused)
            again = not again and find_overturned(self.model, b, firm, stage.h) > 0
            if not again:
                break
            # Its neighbours have followed a strand that turned too far: all are solved once more.
            factor_stages(self.model, System(factors, b), at, outer, firm, stage, rule)
        add_impulses(exchanged, self._room("received", alone))
        return b

    def _judge(self, here: Prediction, dtype: DTypeLike) -> np.ndarray:
        """Mark the strands that an interaction wants to be solved again, (blocks, W)."""
        again = np.zeros(len(here.points), np.bool_)
        lanes = np.zeros(self.axis.strands.shape, dtype)
        for interaction in self.interactions:
            interaction.judge(here, again)
        self.axis.scatter(again, lanes)
        return lanes

    def _spread(self, contact_dv: np.ndarray, x: np.ndarray) -> np.ndarray | float:
        """Spread what other strands did to points over particles."""
        if not self.coupling:
            return 0.0
        lanes = np.zeros_like(x)
        self.axis.scatter(contact_dv, lanes)
        return lanes

    def _room(self, name: str, like: np.ndarray, numbers: int = 3, dtype: DTypeLike = None) -> np.ndarray:
        """Return a buffer of numbers per particle or point, the same for every solve; zeros at first."""
        if name not in self._memory:
            self._memory[name] = np.zeros((like.shape[0], numbers, *like.shape[2:]), dtype or like.dtype)
        return self._memory[name]


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
        positions, in reverse order. Hair that bodies and other hair pull beyond its length slips through them: the
        strain limit has the last word, with an excess that corrections may leave. Held, such hair would store the work
        of the pull, and be flung away when it is released.

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
        if end.moved:
            for interaction in self.interactions:
                interaction.limit(state.x, step.held, STRETCH)
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
