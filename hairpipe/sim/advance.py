"""One frame of the simulation, in steps."""

from collections.abc import Callable, Sequence

import numpy as np

from hairpipe.data import Ends, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.levelset.collider import MovingSurface
from hairpipe.sim.boundary import ClampPath, about, clamp_at, follow, origin_of, place
from hairpipe.sim.build import surroundings_of
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.integrators.choice import gravity_of, integrator_of
from hairpipe.sim.integrators.step_size import TooManySteps, crossing_limit, limits_of, next_step
from hairpipe.sim.settings import Scene
from hairpipe.sim.state import State, Step
from hairpipe.sim.statics.sag_free import stand
from hairpipe.spatial.segments import LostPoints

AT_FIRST = np.empty((0, 2), np.int32), np.empty((0, 2)), np.inf, 1.0
"""Nothing sticks, nothing has crossed, and nothing is stretched."""
Lead = Mesh | Ends | None
"""What leads the roots: a body, or ends that are driven; None: they stand still."""


def start(hair: HairModel, lead: Lead, scene: Scene) -> HairState:
    """Put the groom where its roots are, moving with them.

    Its springs are at rest, so it begins to fall freely; with a sag-free start they carry it. BadInput as for `stand`.
    """
    positions, velocities = place(lead, hair.groom, hair.rest, hair.layout)
    gravity = gravity_of(scene).astype(hair.layout.dtype)
    if scene.sag_free is None:
        tensions = np.zeros_like(hair.model.inverse_lengths)
        accelerations = _at_first(gravity[:, None], velocities, scene)
        return HairState(positions, velocities, accelerations, tensions, tensions[:0], *AT_FIRST)
    origin = origin_of(positions, hair.layout)
    near = about(origin, positions, hair.layout)
    stance = stand(hair.model, hair.layout, hair.groom.ids, near, gravity, scene.sag_free)
    # What stands as groomed stays where it is, to the bit.
    positions = positions + (stance.positions - near)
    velocities = follow(lead, hair.groom, positions, hair.layout)
    pull = np.where(stance.rests[:, None], 0.0, gravity[:, None])
    accelerations = _at_first(pull, velocities, scene)
    return HairState(positions, velocities, accelerations, stance.tensions, stance.inverse_lengths, *AT_FIRST)


def _at_first(pull: np.ndarray, velocities: np.ndarray, scene: Scene) -> np.ndarray:
    """Find accelerations by still air and a pull [m/s^2]; NaN, not known, where more acts: it is not evaluated yet."""
    if scene.wind is not None or scene.interactions:
        return np.full_like(velocities, np.nan)
    return pull - scene.air.drag * velocities


def advance_frame(
    hair: HairModel,
    state: HairState,
    leads: tuple[Lead, Lead],
    bodies: Sequence[MovingSurface],
    frame: float,
    scene: Scene,
    began: float = 0.0,
    watch: Callable[[State, float, float], None] | None = None,
) -> HairState:
    """Carry hair from the previous frame to this one.

    leads   what leads the roots at the previous and at this frame
    bodies  that hair does not pass through
    frame   time between them [s]
    began   time of the shot at the previous frame [s]
    watch   sees the motion after every step, about the middle of the roots, with the times at which the step began and
            ended since the previous frame [s]

    Raises ArithmeticError, naming strands, where what strands do to each other cannot be found as they are not finite,
    and where a frame takes too many steps.
    """
    model = hair.model if not len(state.inverse_lengths) else hair.model._replace(inverse_lengths=state.inverse_lengths)
    origin = origin_of(state.positions, hair.layout)
    arrays = (about(origin, state.positions, hair.layout), state.velocities, state.accelerations, state.tensions)
    motion = State(*(array.copy() for array in arrays))
    path = ClampPath(*(clamp_at(lead, hair.groom, hair.rest, hair.layout, origin) for lead in leads), frame)
    around = surroundings_of(hair, model, state, bodies, scene, began, origin)
    integrator, crossings = integrator_of(scene), crossing_limit(scene.steps, state.pace)
    limits = [*limits_of(scene.steps, model, around), crossings]
    time, left = 0.0, scene.steps.most
    while time < frame * (1 - 1e-9):
        try:
            dt = next_step(limits, motion, path, time, left)
            integrator.advance(model, motion, Step(path, time, dt), around)
        except LostPoints as lost:
            raise _lost(hair, lost.points) from None
        except TooManySteps as many:
            raise _too_many(hair, scene, many) from None
        left -= 1
        crossings.follow(dt, around.crossed)
        if watch is not None:
            watch(motion, time, time + dt)
        time += dt
    moved = origin[:, None] + motion.x, motion.v, motion.a, motion.T
    kept = state.inverse_lengths, state.stuck, state.stuck_at, crossings.step, state.stretched
    return around.remember(HairState(*moved, *kept))


def strands_of(hair: HairModel, state: HairState) -> Strands:
    """Collect what is shown: the axis of every strand; ArithmeticError naming strands that are not finite."""
    points, velocities = hair.layout.axis(state.positions), hair.layout.axis(state.velocities)
    finite = np.isfinite(points).all(1) & np.isfinite(velocities).all(1)
    if not finite.all():
        raise _lost(hair, np.flatnonzero(~finite))
    return Strands(points, velocities.astype(np.float32), hair.layout.offsets, hair.diameter)


def _too_many(hair: HairModel, scene: Scene, many: TooManySteps) -> ArithmeticError:
    """Name the strand and the setting by which a frame takes too many steps."""
    who = "hair" if many.lane is None else f"strand {hair.groom.ids[hair.layout.strands[many.lane]]}"
    asked = getattr(scene.steps, many.setting)
    mend = f"more by steps.most, or fewer by a greater steps.{many.setting}"
    what = f"{who} takes more than {scene.steps.most:,} steps in a frame by steps.{many.setting} = {asked:g}"
    return ArithmeticError(f"{what}: there are {many.steps:.2g} to go ({mend})")


def _lost(hair: HairModel, points: np.ndarray) -> ArithmeticError:
    """Name the strands of points, (n,), that are not finite."""
    strands = np.unique(np.searchsorted(hair.layout.offsets, points, side="right") - 1)
    listed = ", ".join(map(str, hair.groom.ids[strands[:10]]))
    return ArithmeticError(f"{len(strands)} strands are not finite, among them ids {listed}")
