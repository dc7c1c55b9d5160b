"""A shot of strands: their start, and their steps of time through a frame.

Single precision is chosen from the contacts of hair, its steps, stiffness and mass.

The matrix of an implicit step adds the stiffness h^2 k to the mass m, and the rounding error of the elimination grows
with their ratio: with the square of the number of explicit steps in a step,

    N = dt sqrt(max_p sum_s 4 k_s / (m_p l_s)),

the sum running over the springs s at a particle p. At N = 4,000 the rounding error, 6e-8 N^2, equals the mass. For
hair without contact the effect depends on the model: hair of 25 cm in a shake has an error of 22 % of its length as a
network at N = 1,650; as a rod at N = 740 the error is 0.001 % larger than in double precision
(`graphs/experiments/precision.toml`). So the largest N allowed is a property of the model, `ModelKind.single_limit`. At
that limit rounding moves falling hair by less than the error of a step of 1/240 s (`tests/shot/test_precision.py`).

Hair on a body has three times the error of double precision and saves no time, since queries of the body dominate;
hair in contact with hair saves a tenth, and its trajectories diverge. So hair with possible contacts is computed in
double precision, as is sag-free hair, whose springs cancel. Couplings between strands and the factors used there are
always in single precision: they take no part in an elimination.

A frame is computed about the middle of the roots (`boundary.origin_of`), and positions between frames are in double
precision: single precision rounds them to 6e-8 of the distance from that middle, anywhere in the world.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal
from warnings import warn

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider, SdfSample
from hairpipe.geometry.segments import LostPoints
from hairpipe.laws.settings import BodyContact, Rest, check_rest
from hairpipe.shot import shot
from hairpipe.shot.breeze import warn_of_storm
from hairpipe.shot.build import bodies_of, check_scheme, gravity_of, integrator_of, surroundings_of, with_interactions
from hairpipe.shot.goals import goals_of
from hairpipe.shot.locks import advance_locked, check_locks
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame, move_over_cut
from hairpipe.solve.boundary import ClampPath, about, clamp_at, follow, origin_of, place
from hairpipe.solve.integrator import lead_past_tips, rows_of
from hairpipe.solve.lost import are_finite
from hairpipe.solve.sag_free import find_initial_state
from hairpipe.solve.stage import State, Step
from hairpipe.solve.step_size import TooManySteps, crossing_limit, limits_of, next_step
from hairpipe.solve.stretch import STRETCH
from hairpipe.strands.hair_model import HairModel, HairModels
from hairpipe.strands.interface import may_be_lost
from hairpipe.strands.layout import relaid
from hairpipe.values import Groom, Mesh, Strands
from hairpipe.values.groom import Driver, lengths_at_points, reach_of, segment_lengths
from hairpipe.values.hair import HairState
from hairpipe.values.strand_arrays import name_strands
from hairpipe.values.triangles import area_vectors
from hairpipe.volume.targeting import volume_target

SHALLOW = 2e-3
"""A root that lies so little below the skin is an ordinary one [m], whatever its segments are."""
FEW = 0.01
"""Share of the strands that may repeat steps in a frame without a warning."""
MORE = 1.1
"""Smallest ratio of a new stretch to the reported one."""
GROWN = 1.1
"""Smallest ratio of the size of skin that is reported, of later to earlier skin or the opposite."""
GROWN_MORE = 1.2
"""The same of a size to the one that was reported last."""
_FREE = 0.1  # taken as the limit where a scene has none
_EXACT = 0.005


def warn_of_sweep(scene: Scene) -> None:
    """Warn where the published solver of contact is chosen, which gives energy to hairs that touch."""
    if scene.collisions is not None and scene.collisions.solver == "sweep":
        message = 'collisions.solver = "sweep" adds energy to strands that rest on each other without friction'
        warn(f'{message}, so that they do not come to rest (solver = "coupled" avoids this)', stacklevel=3)


def warn_of_weight(hair: HairModel, scene: Scene) -> None:
    """Warn of strands whose weight stretches them beyond the strain limit, which alone holds them: they fall on."""
    if scene.strain is None:
        return
    first = hair.model.first
    beyond = np.cumsum(hair.model.mass[::-1].astype(float), axis=0)[::-1]  # of all strands up to the last
    masses = beyond - np.repeat(np.append(beyond, np.zeros_like(beyond[:1]), axis=0)[first[1:]], np.diff(first), axis=0)
    strains = np.maximum.reduceat(scene.gravity * masses / hair.model.constants[:, 0], first[:-1])
    soft = (strains > scene.strain.tolerance) & ~hair.layout.idle
    if soft.any():
        names = name_strands(hair.groom.ids[np.sort(hair.layout.strands[soft])])
        stretched = f"the weight of {np.count_nonzero(soft)} strands stretches them by up to {strains[soft].max():.2g}"
        warn(
            f"{stretched}, above strain.tolerance = {scene.strain.tolerance:g}, and they do not come to rest: {names} "
            "(a larger tolerance, or a smaller material.softening)",
            stacklevel=3,
        )


def warn_of_deep_roots(hair: HairModel, positions: np.ndarray, bodies: Sequence[Collider]) -> None:
    """Warn of the strands whose roots are so deep inside bodies at present that their first segments end inside.

    positions  of the particles [m], (rows, 3, W)
    """
    offsets = hair.layout.offsets
    points = hair.layout.axis(positions).astype(float)[offsets[:-1]]
    probe = SdfSample.blank(len(points), 0.0)
    for body in bodies:
        body.probe(points, 0.0, probe)
    first = hair.groom.points[offsets[:-1] + 1] - hair.groom.points[offsets[:-1]]
    deep = -probe.distance > np.maximum(np.linalg.norm(first, axis=1), SHALLOW)
    if deep.any():
        order = np.argsort(probe.distance, kind="stable")[: np.count_nonzero(deep)]
        ids = hair.groom.ids[order[deep[order]]]
        message = f"{np.count_nonzero(deep)} of {len(deep)} roots are inside the body by more than a segment"
        worst = f"the deepest by {-1e3 * probe.distance.min():.3g} mm: {name_strands(ids)}"
        mend = "roots on the skin: check unit, position and pose of groom and body"
        warn(f"{message}, {worst} ({mend})", stacklevel=3)


def warn_of_stretch(hair: HairModel, positions: np.ndarray, scene: Scene, frame: int, reported: float) -> float:
    """Warn of the strand with the largest stretch, if it is pulled as far as corrections may stretch hair, or farther.

    positions  of the particles [m], (rows, 3, W)
    reported   last stretch that was reported; only a stretch that exceeds it by a margin is reported again

    Returns the last stretch that was reported.
    """
    offsets = hair.layout.offsets
    rest = segment_lengths(hair.groom.points, hair.layout.offsets)
    stretch = segment_lengths(hair.layout.axis(positions), offsets) / rest
    worst = int(np.argmax(stretch))
    limit = _FREE if scene.strain is None else scene.strain.tolerance
    if not stretch[worst] > max((1.0 + limit) * (1.0 + STRETCH) - _EXACT, MORE * reported):
        return reported
    strand = int(np.searchsorted(offsets[1:] - np.arange(1, len(offsets)), worst, side="right"))
    far = f"a segment of strand {hair.groom.ids[strand]} is stretched to {stretch[worst]:.3g} times its length"
    warn(
        f"{far} at frame {frame}, above the limit of {1.0 + limit:.3g}: the constraints exceed the strain limit",
        stacklevel=3,
    )
    return float(stretch[worst])


def warn_of_growth(
    groom: Groom, drivers: tuple[Driver, Driver], frame: int, grown: float, reported: float
) -> tuple[float, float]:
    """Warn of skin that has grown, or shrunk, at the roots since the first frame: hair keeps its length.

    drivers   bodies at the previous frame and at this one; ends are of constant size
    grown     size of the skin at the previous frame over that at the first, the median over strands
    reported  the last ratio that was reported; only a ratio that differs from it by a margin is reported again

    Returns the ratio at this frame, and the last one that was reported.
    """
    here = [Mesh(b.points, b.triangles[groom.root_triangles]) for b in drivers if isinstance(b, Mesh)]
    if len(here) < 2:
        return grown, reported
    first, second = (np.linalg.norm(area_vectors(skin), axis=1) for skin in here)
    has_area = (first > 0.0) & (second > 0.0)
    if has_area.any():
        grown *= float(np.sqrt(np.median(second[has_area] / first[has_area])))
    change = abs(np.log(grown / reported))
    if not change > np.log(GROWN if reported == 1.0 else GROWN_MORE):
        return grown, reported
    done = "grown" if grown > 1.0 else "shrunk"
    message = f"the skin at the roots has {done} by {100.0 * abs(grown - 1.0):.0f} % since the first frame"
    warn(f"{message}, at frame {frame}, and hair keeps its length (a body of constant size)", stacklevel=3)
    return grown, grown


def warn_of_lost(hair: HairModel, before: HairState, after: HairState, frame: int) -> None:
    """Name the strands that repeated a step in a frame, unless they are few of many; see `solve/lost.py`."""
    if not may_be_lost(hair.model):
        return
    rows = hair.model.first[:-1]
    used = ~hair.layout.idle
    repeats = after.tensions[rows, 1]
    again = (repeats > before.tensions[rows, 1]) & used
    count = np.count_nonzero(again)
    if count > FEW * np.count_nonzero(used):
        names = name_strands(hair.groom.ids[np.unique(hair.layout.strands[again])])
        message = f"{count} strands were re-solved with backward Euler at frame {frame}: {names}"
        steps = int(repeats[used].sum())
        warn(f"{message} ({steps} such steps of all strands so far; a shorter steps.longest avoids them)", stacklevel=3)


def warn_of_held(hair: HairModel, now: State, mended: np.ndarray, steps: int, frame: int) -> None:
    """Warn of the strands that could not be solved in some steps of a frame, see `solve/lost.py`.

    now     hair at the end of the frame, with the number of steps
    mended  strands that were not finite at the start of the frame, (blocks, W) bool

    Raises ArithmeticError if no step could be solved for any strand, or if strands are held in single precision while
    double is available.
    """
    held = now.held
    used = ~hair.layout.idle
    if (mended & used).any():
        names = name_strands(hair.groom.ids[np.sort(hair.layout.strands[mended & used])])
        message = f"{np.count_nonzero(mended & used)} strands were not finite before frame {frame}"
        warn(f"{message} and restart from the groom: {names}", stacklevel=3)
    if not held.any():
        return
    count = np.count_nonzero(held[used])
    total = np.count_nonzero(used)
    names = name_strands(hair.groom.ids[np.sort(hair.layout.strands[used & (held > 0)])])
    message = f"{count} of {total} strands had no solution in {held.max()} of {steps} steps of frame {frame}: {names}"
    if now.failed >= steps:
        raise ArithmeticError(f"diverged: {message}")
    if hair.in_double is not None:
        raise ArithmeticError(f"{message} (in single precision)")
    warn(f"{message} (they moved rigidly with their roots)", stacklevel=3)


# pyright: reportCallIssue=false


def restored(hair: HairModel, state: HairState, driver: Driver) -> tuple[HairState, np.ndarray]:
    """Return a state in which non-finite strands are reset to the groom, at rest relative to their roots; pure."""
    rows = state.positions, state.velocities, state.accelerations, state.tensions
    finite = np.all([are_finite(hair.model, values) for values in rows], axis=0)
    if finite.all():
        return state, ~finite
    lost = rows_of(hair.model, ~finite)
    numbers = np.arange(hair.layout.offsets[-1])
    for strand in np.unique(hair.layout.strands[~finite]):
        numbers[hair.layout.offsets[strand] : hair.layout.offsets[strand + 1]] = -1
    positions, velocities = place(driver, hair.groom, hair.rest, hair.layout)
    mended = replace(
        state,
        positions=np.where(lost, positions, state.positions),
        velocities=np.where(lost, velocities, state.velocities),
        accelerations=np.where(lost, 0.0, state.accelerations).astype(state.accelerations.dtype),
        fresh=state.fresh | ~finite,
        tensions=np.where(lost, 0.0, state.tensions).astype(state.tensions.dtype),
        touching=state.touching and state.touching.renumbered(numbers),
        shear=state.shear and state.shear.renumbered(numbers),
    )
    return mended, ~finite


def converted(state: HairState, here: HairModel, there: HairModel) -> HairState:
    """Return a state of strands in one precision as one of the same strands in another; pure."""
    names = ("velocities", "accelerations", "tensions", "inverse_lengths")
    kept = {name: getattr(state, name) for name in names if getattr(state, name) is not None}
    cast = {name: relaid(values, here.layout, there.layout).astype(there.layout.dtype) for name, values in kept.items()}
    positions, fresh = (relaid(values, here.layout, there.layout) for values in (state.positions, state.fresh))
    return replace(state, positions=positions, fresh=fresh, **cast)


@dataclass(frozen=True, eq=False)
class StrandSimulation:
    """Strands in one precision, in a scene; a `hairpipe.shot.shot.Simulation`."""

    hair: HairModel
    scene: Scene

    @property
    def groom(self) -> Groom:
        """The strands whose roots are led."""
        return self.hair.groom

    def start(self, frame: Frame) -> HairState:
        """Return the groom where its roots are.

        Warns of absent connections, deep roots, energy from a solver, storms, and soft strands.
        """
        scene = self._scene_at(frame)
        shot.warn_of_connections(self.groom, frame, contact=scene.contact != BodyContact())
        state = start(self.hair, frame.drivers[1], scene)
        warn_of_deep_roots(self.hair, state.positions, self._bodies_at(frame))
        warn_of_sweep(scene)
        warn_of_storm(scene.wind)
        warn_of_weight(self.hair, scene)
        return state

    def advance(self, state: HairState, frame: Frame) -> HairState:
        """Return the hair at a frame; warns of strands that were lost, of stretch, and of skin that grows."""
        hair = self.hair
        scene = self._scene_at(frame)
        bodies = self._bodies_at(frame)

        def simulate(strands: HairModel, before: HairState, drivers: tuple[Driver, Driver]) -> HairState:
            goals = goals_of(strands, drivers, frame.pins, scene.goal, frame.frame_dt)
            held = with_interactions(scene, *goals) if goals else scene
            return advance_frame(strands, before, drivers, bodies, frame.frame_dt, held, frame.began)

        if scene.locks is None:
            moved = simulate(hair, state, frame.drivers)
        else:
            moved = advance_locked(hair, state, frame, scene, simulate)
        warn_of_lost(hair, state, moved, frame.number)
        stretched = warn_of_stretch(hair, moved.positions, scene, frame.number, state.stretched)
        size = state.grown, state.grown_reported
        grown, reported = warn_of_growth(hair.groom, frame.drivers, frame.number, *size)
        return replace(moved, stretched=stretched, grown=grown, grown_reported=reported)

    def move_over_cut(self, state: HairState, drivers: tuple[Driver, Driver]) -> HairState:
        """Return the hair moved with its roots, see `hairpipe.shot.shot`."""
        return move_over_cut(self.hair, state, drivers)

    def _bodies_at(self, frame: Frame) -> list[Collider]:
        """Build the bodies of a frame."""
        return bodies_of(frame.surfaces, frame.parts, self.scene.contact, frame.frame_dt)

    def _scene_at(self, frame: Frame) -> Scene:
        """Return the scene with the target of a frame; BadInput where hair cannot be in locks as asked."""
        scene = _attracted(self.hair, frame, self.scene)
        if scene.locks is not None:
            check_locks(self.hair, frame.drivers[1], scene)
        return scene


def next_state(hair: HairModel, previous: HairState | None, frame: Frame, scene: Scene) -> HairState:
    """Return the hair at a frame from that at the previous frame, which is absent at the first. Pure.

    A frame in which single precision loses strands is recomputed in double precision.

    Raises BadInput if only one of the target and the group `volume.target` is given, and ArithmeticError as
    `advance_frame`.
    """
    try:
        return shot.next_state(StrandSimulation(hair, scene), previous, frame)
    except ArithmeticError as lost:
        if hair.in_double is None or previous is None:
            raise
        warn(f"{lost}: computed again in double precision", stacklevel=2)
    finer = hair.in_double()
    state = shot.next_state(StrandSimulation(finer, scene), converted(previous, hair, finer), frame)
    return converted(state, finer, hair)


def _attracted(hair: HairModel, frame: Frame, scene: Scene) -> Scene:
    """Return the scene with the interaction that pulls hair to the target, if there is one."""
    target = scene.volume.target if scene.volume is not None else None
    if target is None and frame.target is None:
        return scene
    if target is None or frame.target is None:
        missing = "[volume.target]" if target is None else "in.target"
        raise BadInput(f"attraction to a density requires {missing}", right="both, or neither")
    points, offsets = hair.groom.points, hair.layout.offsets
    reach = hair.once("reach", lambda: reach_of(points, offsets))
    lengths = hair.once("lengths", lambda: lengths_at_points(points, offsets))
    leader = volume_target(target, frame.target, (offsets, reach, lengths), frame.frame_dt)
    return with_interactions(scene, leader)


def start(hair: HairModel, driver: Driver, scene: Scene) -> HairState:
    """Place the groom at its roots, with their velocity.

    Its springs are at rest, so it starts in free fall; with a sag-free start they support it. Raises BadInput as
    `stand`, and if the model does not support the scheme.
    """
    check_scheme(hair.model, scene)
    layout = hair.layout
    positions, velocities = place(driver, hair.groom, hair.rest, layout)
    gravity = gravity_of(scene).astype(layout.dtype)
    tensions = np.zeros_like(hair.model.inverse_lengths)
    inverse_lengths = None
    pull = gravity[:, None]
    if scene.rest.in_equilibrium:
        shares = shares_of_weight(hair, scene.rest)
        origin = origin_of(positions, layout)
        near = about(origin, positions, layout)
        initial = find_initial_state(hair.model, layout, hair.groom.ids, near, gravity, scene.rest, shares)
        # What stands as groomed stays where it is, to the bit.
        positions = positions + (initial.positions - near)
        velocities = follow(driver, hair.groom, positions, layout)
        tensions = initial.tensions
        inverse_lengths = initial.inverse_lengths if shares.any() else None
        sags = initial.sags[:, None]
        pull = np.where(sags > 0.0, sags * pull, 0.0)
    return HairState(
        positions,
        velocities,
        pull - scene.air.drag.value * velocities,
        np.full(layout.strands.shape, scene.air_interacts),  # no acceleration contains it yet
        tensions,
        inverse_lengths,
        stuck=np.empty((0, 2), np.int32),
        stuck_at=np.empty((0, 2)),
        pace=np.inf,
        stretched=1.0,
    )


def shares_of_weight(hair: HairModel, rest: Rest) -> np.ndarray:
    """Return the share of its weight that each strand bears as groomed, (blocks, W); BadInput as `check_rest`."""
    offsets = hair.layout.offsets
    values = (hair.values_of(getattr(rest, name), f"rest.{name}") for name in ("shape", "balanced"))
    shape, balanced = (np.broadcast_to(each if np.ndim(each) == 0 else each[0], offsets[-1]) for each in values)
    wrong = (np.minimum.reduceat(shape, offsets[:-1]) < 1.0) & (balanced[offsets[:-1]] > 0.0)
    check_rest(bool(wrong.any()), name_strands(hair.groom.ids[wrong]))
    return balanced[offsets[:-1]][hair.layout.strands]


def advance_frame(
    hair: HairModel,
    state: HairState,
    drivers: tuple[Driver, Driver],
    bodies: Sequence[Collider],
    frame_dt: float,
    scene: Scene,
    began: float = 0.0,
    watch: Callable[[State, float, float], None] | None = None,
) -> HairState:
    """Advance hair from the previous frame to this one; pure.

    drivers   drivers of the roots at the previous and at this frame
    bodies    bodies that hair collides with
    frame_dt  time between the frames [s]
    began     time of the shot at the previous frame [s]
    watch     called after every step with the state, about the middle of the roots, and the start and end of the step
              since the previous frame [s]

    Strands without a solvable step are held and reported, see `solve/lost.py`; those that are not finite at the
    start of the frame are reset to the groom.

    Raises ArithmeticError if no step can be solved for any strand, if roots are not finite, if a frame takes too many
    steps, and if strands are held that are also available in double precision.
    """
    state, mended = restored(hair, state, drivers[0])
    origin = origin_of(state.positions, hair.layout)
    model = hair.model
    if state.inverse_lengths is not None:
        model = model._replace(inverse_lengths=state.inverse_lengths)
    now = State.begin(state, about(origin, state.positions, hair.layout))
    path = ClampPath(*(clamp_at(driver, hair.groom, hair.rest, hair.layout, origin) for driver in drivers), frame_dt)
    around = surroundings_of(hair, model, state, bodies, scene, began, origin)
    integrator = integrator_of(scene)
    crossings = crossing_limit(scene.steps, state.pace)
    limits = [*limits_of(scene.steps, model, around), crossings]
    time = 0.0
    left = scene.steps.most
    frame = round(began / frame_dt) + 1
    while time < frame_dt * (1 - 1e-9):
        try:
            dt = next_step(limits, now, path, time, left)
            with np.errstate(over="ignore", invalid="ignore"):  # strands that a step loses are found after it
                integrator.advance(model, now, Step(path, time, dt), around)
                lead_past_tips(model, now, path.held)
        except LostPoints as lost:
            raise _lost(hair, lost.points) from None
        except TooManySteps as many:
            raise _too_many(hair, scene, many) from None
        left -= 1
        crossings.follow(dt, around.crossed)
        if watch is not None:
            watch(now, time, time + dt)
        time += dt
    warn_of_held(hair, now, mended, scene.steps.most - left, frame)
    moved = replace(
        state,
        positions=origin[:, None] + now.x,
        velocities=now.v,
        accelerations=now.a,
        fresh=now.fresh,
        tensions=now.T,
        pace=crossings.step,
        touching=None,
        impulses=None,
    )
    return around.remember(moved)


def strands_of(hair: HairModel, state: HairState) -> Strands:
    """Collect what is shown: the axis of every strand; ArithmeticError naming strands that are not finite."""
    points, velocities = hair.layout.axis(state.positions), hair.layout.axis(state.velocities)
    if not (np.isfinite(points).all() and np.isfinite(velocities).all()):
        finite = np.isfinite(points).all(1) & np.isfinite(velocities).all(1)
        raise _lost(hair, np.flatnonzero(~finite))
    return Strands(points, velocities.astype(np.float32), hair.layout.offsets, hair.diameter, hair.diameters)


def _too_many(hair: HairModel, scene: Scene, many: TooManySteps) -> ArithmeticError:
    """Name the strand and the setting by which a frame takes too many steps."""
    names = "hair" if many.lane is None else f"strand {hair.groom.ids[hair.layout.strands[many.lane]]}"
    asked = getattr(scene.steps, many.setting)
    mend = f"more by steps.most, or fewer by a greater steps.{many.setting}"
    what = f"{names} needs more than {scene.steps.most:,} steps per frame by steps.{many.setting} = {asked:g}"
    return ArithmeticError(f"{what}: {many.steps:.2g} remain ({mend})")


def _lost(hair: HairModel, points: np.ndarray) -> ArithmeticError:
    """Name the strands of points, (n,), that are not finite."""
    strands = np.unique(np.searchsorted(hair.layout.offsets, points, side="right") - 1)
    listed = ", ".join(map(str, hair.groom.ids[strands[:10]]))
    return ArithmeticError(f"{len(strands)} strands are not finite, among them ids {listed}")


PrecisionAsked = Literal["automatic", "double", "single"]


def choose_precision(
    asked: PrecisionAsked, models: HairModels, scene: Scene, *, bodies: bool, first: bool = False
) -> HairModel:
    """Return strands in the requested precision, or in the one that suffices for the scene.

    bodies  whether there are bodies that hair may touch
    first   whether this is the first frame of a shot, at which warnings are emitted

    Warns if single precision was chosen, and if it was requested but is not safe. Raises BadInput as
    `HairModels.in_precision`, and if single precision was requested but is impossible.
    """
    if first:
        models.kind.warn(models.groom, models.fibres)
    if asked == "single" and scene.rest.in_equilibrium:
        message = "a start in equilibrium is impossible in single precision"
        raise BadInput(message, where="precision", right='"automatic" or "double"')
    if asked == "double":
        return models.in_precision("double")
    needs = needs_double(scene, bodies)
    steps = 0.0 if needs else scene.steps.longest * models.highest_frequency
    limit = models.kind.single_limit
    if steps > limit:
        longest = scene.steps.longest * limit / steps
        needs = f"steps beyond {longest:.2g} s of hair so stiff and light"
    if first and not needs and asked == "automatic":
        message = f"hair without contact takes {steps:.0f} explicit steps per step, of {limit:.0f} allowed"
        warn(f'computed in single precision: {message} (precision = "double" is more accurate)', stacklevel=2)
    if first and needs and asked == "single":
        warn(f'single precision is insufficient for {needs}: precision = "automatic" uses double', stacklevel=2)
    return models.in_precision("single" if asked == "single" or not needs else "double")


def needs_double(scene: Scene, bodies: bool) -> str:
    """Find what in a scene needs double precision, whatever its steps are; empty where nothing does."""
    if bodies:
        return "hair that touches a body"
    if scene.stiction is not None or scene.collisions is not None:
        return "hair that touches hair"
    return "a start in equilibrium" if scene.rest.in_equilibrium else ""
