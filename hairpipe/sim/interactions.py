"""What acts on strands from outside while a stage is solved: wind, the body that holds them, other strands.

A stage that nothing takes part in is one kernel. Otherwise all strands are solved together from where they are foreseen
(`guess_stages`), judged, and solved again where the judgement was wrong: where contact with the body changed.
What couples strands to each other (stiction, hair on hair) makes one system of all, solved by conjugate gradients with
the strands' own factors before it; strands that are solved again see the others where that left them.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import DTypeLike

from hairpipe.kernels.banded import row_size
from hairpipe.kernels.simd_arrays import combine_all, copied
from hairpipe.sim.air.breeze import Breeze
from hairpipe.sim.axis import Axis, axis_of, follow, gather, lanes_with, points_of, scatter, spread
from hairpipe.sim.contact.body.body_contacts import BodyContacts
from hairpipe.sim.contact.hair.hair_contacts import HairContacts
from hairpipe.sim.contact.hair.stiction import stiffest
from hairpipe.sim.filters.length_jump import mark_length_jumps
from hairpipe.sim.filters.limit_strain import limit_all
from hairpipe.sim.layout import Layout
from hairpipe.sim.settings import StrainLimit
from hairpipe.sim.solve.external_terms import ROWS, ROWS_WITH_NEXT, clear, lay_out, velocity_changes
from hairpipe.sim.solve.implicit_stage import Rule, factor_stages, guess_stages, run_stages, update_stages
from hairpipe.sim.solve.strand_inverse import respond
from hairpipe.sim.state import State, Step
from hairpipe.sim.strands.interface import StrandModel

_PASSES = 4  # over the strands for which a judgement was wrong


@dataclass(frozen=True, eq=False)
class Stage:
    """One stage of an integrator: x = xh + h v, M (v - vh) = h f(x, v); see `sim/solve/implicit_stage.py`.

    xh, vh   explicit parts of position and velocity, (rows, 3, W)
    before   positions where the stage began, same shape
    began    velocities there, same shape; the guess, or what drag and friction go by where the guess is another
    ends     held particles at its end, (blocks, 2 clamped, 3, W)
    held     see `Step`
    h        weight of the end, for every strand [s], (blocks, W)
    time     that bodies and wind are those of, at its end but in the nine steps, since the previous frame [s]
    span     that the stage covers [s]
    held_normals  the body holds what a filter has marked, and nothing else: the velocity solve of the paper
    """

    xh: np.ndarray
    vh: np.ndarray
    before: np.ndarray
    began: np.ndarray
    ends: np.ndarray
    held: np.ndarray
    h: np.ndarray
    time: float
    span: float
    held_normals: bool = False


@dataclass(eq=False)
class Surroundings:
    """Everything that acts from outside in a frame; what is None is not there.

    model, layout  of the strands
    strain         how far a segment may be stretched
    began          time of the shot at the previous frame [s]
    origin         about which positions of strands are [m], (3,); what acts on points sees them in the world
    """

    model: StrandModel
    layout: Layout
    strain: StrainLimit | None = None
    wind: Breeze | None = None
    body: BodyContacts | None = None
    hair: HairContacts | None = None
    began: float = 0.0
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))
    _axis: Axis = field(init=False)
    _everyone: np.ndarray = field(init=False)
    _masses: np.ndarray = field(init=False)
    _weights: np.ndarray = field(init=False)
    _jumped: np.ndarray = field(init=False)
    _memory: dict[str, np.ndarray] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self._axis = axis_of(self.layout)
        self._everyone = np.ones(self.layout.strands.shape, self.layout.dtype)
        self._masses = np.empty((self.layout.offsets[-1], 1))
        gather(self._axis, self._everyone, self.model.mass[:, None, :], self._masses)
        self._masses = self._masses[:, 0]
        self._masses[self.layout.offsets[:-1]] = np.inf
        self._weights = np.empty_like(self._masses)
        self._jumped = np.zeros(self.layout.strands.shape, self.layout.dtype)

    def begin(self, motion: State, step: Step) -> None:
        """Look around at the start of a step."""
        self._hold_tips(step.held)
        if self.wind is not None or self.body is not None or self.hair is not None:
            points, speeds = self._places(motion.x), self._points(motion.v)
            if self.wind is not None:
                self.wind.begin(points, self.layout.offsets)
            if self.body is not None:
                self.body.begin(points, speeds, self._masses, step.time, step.dt)
            if self.hair is not None:
                self.hair.begin(points, speeds)

    def _hold_tips(self, held: np.ndarray) -> None:
        """Let nothing move the last segments of strands whose tip is held, (blocks, W): all of a frame is."""
        if len(held):
            marked, last = np.empty(len(self._masses), np.bool_), self.layout.offsets[1:] - 1
            points_of(self._axis, held, marked)
            last = last[marked[last]]
            self._masses[last] = self._masses[last - 1] = np.inf

    def solve(
        self, x: np.ndarray, v: np.ndarray, T: np.ndarray, stage: Stage, rule: Rule, active: np.ndarray | None = None
    ) -> np.ndarray | float:
        """Advance strands through a stage, in place; v is the guess.

        x, v, T  out: at the end of the stage, see `run_stage`
        active      1 for strands that are solved, each for itself, (blocks, W); None: all, together

        Returns the change of velocity that other strands made, no part of the acceleration [m/s], (rows, 3, W), or 0.
        """
        if self.wind is None and self.body is None and self.hair is None and active is None:
            run_stages(self.model, x, v, T, stage.xh, stage.vh, stage.before, stage.ends, stage.held, stage.h, rule)
            return 0.0
        guess_stages(
            self.model, x, v, T, stage.xh, stage.before, stage.began, stage.ends, stage.held, stage.h, stage.span, rule
        )
        together = active is None
        active = np.ones(self.layout.strands.shape, x.dtype) if active is None else active
        again, marked = active, np.empty(len(self._masses), np.bool_)
        points_of(self._axis, active, marked)
        points, speeds, contact_dv = self._places(x), self._points(v), np.zeros((len(self._masses), 3))
        lagged_velocity = speeds if stage.began is v else self._points(stage.began)
        if self.body is not None and not stage.held_normals:
            self.body.foresee(points, stage.time, marked)
        for left in reversed(range(rule.iterations + _PASSES)):
            newton = left >= _PASSES
            points_of(self._axis, again, marked)
            outer = self._surround(points, speeds, lagged_velocity, stage, again, marked, x, anew=newton)
            b = self._solve_once(x, v, T, stage, rule, outer, again, coupled=newton and together)
            if self.hair is not None:
                change = self._room("change", points)
                gather(self._axis, again, b, change)
                self.hair.follow(change, marked, self._room("received", points))
                velocity_changes(marked, self._room("received", points), self._masses, contact_dv)
            update_stages(self.model, x, v, T, b, again, stage.h, rule)
            gather(self._axis, again, x, points)
            np.add(points, self.origin, out=points, where=marked[:, None])
            gather(self._axis, again, v, speeds)
            lagged_velocity = speeds
            wrong = self._judge(points, speeds, stage, marked) * active
            again = active if left > _PASSES else wrong
            if not again.any():
                break
        return self._contact_dv(contact_dv, x)

    def _surround(
        self,
        points: np.ndarray,
        speeds: np.ndarray,
        lagged_velocity: np.ndarray,
        stage: Stage,
        active: np.ndarray,
        marked: np.ndarray,
        like: np.ndarray,
        *,
        anew: bool,
    ) -> np.ndarray:
        """Return what acts on active strands, (blocks, W), and their points marked; see `external_terms.py`.

        points, speeds  where that is linearised [m], [m/s], (P, 3)
        lagged_velocity            velocities that drag and contact between hairs go by [m/s], (P, 3)
        anew            what strands do to each other, too; else it is what solves since then have made of it
        """
        push, damping = self._room("push", points), self._room("damping", points, 6)
        weights = self._weights
        spread(self._axis, stage.h, weights)
        received = push[:0] if self.hair is None else self._room("received", points)
        clear(marked, push, damping)
        if self.wind is not None:
            self.wind.forces(
                points, lagged_velocity, self.layout.offsets, self.began + stage.time, marked, push, damping
            )
        if self.body is not None:
            held = np.zeros_like(marked) if stage.held_normals else marked
            self.body.hold(points, speeds, self._masses, weights, held, push, damping)
        own = np.empty((0, 6), np.float32), np.empty((0, 6), np.float32)
        if self.hair is not None:
            if anew:
                self.hair.linearise(points, speeds, lagged_velocity, self._masses, weights, stage.span, marked)
            self.hair.impulses(marked, received)
            own = self.hair.own
        outer = self._room("outer", like[:: self._axis.stride], self._rows)
        lay_out(self._axis, active, push, damping, speeds, stage.h, received, *own, outer)
        return outer

    def _solve_once(
        self,
        x: np.ndarray,
        v: np.ndarray,
        T: np.ndarray,
        stage: Stage,
        rule: Rule,
        outer: np.ndarray,
        active: np.ndarray,
        *,
        coupled: bool,
    ) -> np.ndarray:
        """Return the change of velocity of active strands, (blocks, W) [m/s], (rows, 3, W).

        coupled  in one system; else every strand sees the others where they are
        """
        coupled = coupled and self.hair is not None
        factors = outer[:0].astype(np.float32)
        if coupled:
            factors = self._room("factors", x, row_size(self.model.shape.reach), np.float32)
        b = self._room("b", x)
        factor_stages(self.model, factors, b, x, v, stage.vh, T, outer, stage.held, active, stage.h, rule)
        if self.hair is not None and coupled:
            alone = self._points(b)

            def ask(impulses: np.ndarray, change: np.ndarray) -> None:
                respond(self.model, self._axis, factors, stage.held, active, impulses, change, b[:0])

            exchanged = self.hair.exchange(ask, alone, self._masses)
            respond(self.model, self._axis, factors, stage.held, active, exchanged, np.empty_like(exchanged), b)
            self._room("received", alone)[:] += exchanged
        return b

    def _judge(self, points: np.ndarray, speeds: np.ndarray, stage: Stage, marked: np.ndarray) -> np.ndarray:
        """Mark the strands whose contact with the body was judged wrongly, (blocks, W)."""
        wrong = np.zeros(self.layout.strands.shape, self.layout.dtype)
        if self.body is not None and not stage.held_normals:
            lanes_with(self._axis, self.body.update_active_set(points, speeds, self._masses, stage.time, marked), wrong)
        return wrong

    def _contact_dv(self, contact_dv: np.ndarray, x: np.ndarray) -> np.ndarray | float:
        """Spread what other strands did to points over particles."""
        if self.hair is None:
            return 0.0
        lanes = np.zeros(x.shape, x.dtype)
        scatter(self._axis, contact_dv, lanes)
        return lanes

    def limit_velocity(self, x: np.ndarray, v: np.ndarray, step: Step) -> None:
        """Change v so that x + dt v keeps the strain limit, in place; x, v (rows, 3, W)."""
        if self.strain is not None:
            target = x + step.dt * v
            limited = target.copy()
            self._limit(limited, self.strain, step)
            v += (limited - target) / step.dt

    def collide(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, step: Step) -> None:
        """Move hair out of the body at the end of a step, and slow it down, in place.

        x, v, before  positions and velocities now, positions at the start of the step, (rows, 3, W)

        What touched is held along its normal by stages that ask for it.
        """
        if self.body is not None:
            touched, normals = self._put_right(x, v, before, step)
            self.body.hold_normals(touched, normals, self._masses, step.dt)

    def let_go(self) -> None:
        """Let the body hold nothing until `collide` finds what touches it, or a stage looks."""
        if self.body is not None:
            self.body.let_go()

    def end(self, motion: State, before: np.ndarray, step: Step) -> np.ndarray | float:
        """Correct what a step found, in place; before is where it began [m], (rows, 3, W).

        Contact gives nothing back; what is near repels, where that is not part of the solve; what passed through each
        other is brought back, strain is limited, and the body has the last word.

        Returns how that changed velocities [m/s], (rows, 3, W), or 0.
        """
        self._jumped[:] = 0.0
        if self.hair is None and self.strain is None and self.body is None:
            return 0.0
        if self.hair is not None:
            self.hair.let_go()
        found = 0.0 if self.body is None and self.hair is None else copied(motion.v)
        if self.body is not None:
            follow(self._axis, self.body.stop(self._points(motion.v)), 1.0, motion.v)
        self.repel(motion.x, motion.v, step, elastic=True)
        solved = copied(motion.x)
        self.cross(motion.x, motion.v, before, step)
        if self.strain is not None:
            self._limit(motion.x, self.strain, step)
        if self.body is not None:
            self._put_right(motion.x, motion.v, before, step)
        mark_length_jumps(self.model, solved, motion.x, self._jumped)
        if isinstance(found, np.ndarray):
            combine_all(found, 1.0, motion.v, -1.0, found)
        return found

    def discontinuous(self, like: np.ndarray) -> np.ndarray:
        """Mark the strands whose forces jumped in this step, (blocks, W), of the dtype of an array.

        Contact with the body began or ended there, or moved a point out, or what `end` put right stretched or relieved
        hairs.
        """
        lanes = np.zeros(self.layout.strands.shape, like.dtype)
        if self.body is not None:
            lanes_with(self._axis, self.body.discontinuous, lanes)
        return np.maximum(lanes, self._jumped)

    def cross(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, step: Step) -> None:
        """Bring back hair that passed through hair in a step, in place; arguments as for `collide`."""
        if self.hair is not None:
            change = self.hair.collide(self._places(before), self._places(x), self._masses, step.dt)
            if change is not None:
                follow(self._axis, change, step.dt, x)
                follow(self._axis, change, 1.0, v)

    @property
    def crossed(self) -> float:
        """Pairs a segment that the last step had to keep from passing through each other."""
        return 0.0 if self.hair is None else self.hair.crossed

    def repel(self, x: np.ndarray, v: np.ndarray, step: Step, *, elastic: bool) -> None:
        """Let hair that is near push hair away by impulses, in place; x, v (rows, 3, W)."""
        if self.hair is not None and self.hair.sweeps:
            speeds = self._points(v)
            slowed = speeds.copy()
            self.hair.repel(self._places(x), slowed, self._masses, step.dt, elastic=elastic)
            follow(self._axis, slowed - speeds, 1.0, v)

    def body_speed(self) -> float:
        """Find a speed that no body exceeds in this frame [m/s]."""
        return 0.0 if self.body is None else self.body.speed

    def stiffest_connections(self) -> float:
        """Bound what stiction adds to the square of the highest frequency [1/s^2]."""
        if self.hair is None or self.hair.stiction is None:
            return 0.0
        return stiffest(self.hair.connections, self._masses, self.hair.stiction)

    def _limit(self, x: np.ndarray, strain: StrainLimit, step: Step) -> None:
        """Limit the strain of hair, in place, but for strands held at both ends: springs alone share out theirs."""
        limits = np.full(self.layout.strands.shape, 1.0 + strain.tolerance, x.dtype)
        if len(step.held):
            limits[step.held > 0.0] = np.inf
        limit_all(self.model, x, limits)

    def _put_right(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, step: Step) -> tuple[np.ndarray, np.ndarray]:
        """Move hair out of the body; return which points touched it and its normals there."""
        assert self.body is not None
        begun, ended, speeds = self._places(before), self._places(x), self._points(v)
        dx, dv, touched, normals = self.body.correct(begun, ended, speeds, self._masses, step.time, step.dt)
        follow(self._axis, dx, 1.0, x)
        follow(self._axis, dv, 1.0, v)
        return touched, normals

    @property
    def _rows(self) -> int:
        """Numbers by which points are acted on from outside."""
        return ROWS if self.hair is None else ROWS_WITH_NEXT

    def _places(self, x: np.ndarray) -> np.ndarray:
        """Return where the points of strands at x, (rows, 3, W), are in the world [m], (P, 3) float64."""
        points = self._points(x)
        points += self.origin
        return points

    def _points(self, lanes: np.ndarray) -> np.ndarray:
        points = np.empty((len(self._masses), lanes.shape[1]))
        gather(self._axis, self._everyone, lanes, points)
        return points

    def _room(self, name: str, like: np.ndarray, numbers: int = 3, dtype: DTypeLike = None) -> np.ndarray:
        """Give room for so many numbers a particle or a point, the same for every solve; zeros at first."""
        if name not in self._memory:
            self._memory[name] = np.zeros((like.shape[0], numbers, *like.shape[2:]), dtype or like.dtype)
        return self._memory[name]
