"""A bar that is driven through a tuft and back: the steps and speeds at which contact fails."""

from collections.abc import Callable, Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.contact.bar import LENGTH, SEGMENTS, axis_at, bar_at, passed_through, roots_at
from hairpipe.graphs.experiments.studies.contact.worst import FLUNG, FLUNG_LEAST, GRAVITY, Seen, Worst, signs
from hairpipe.graphs.experiments.studies.integrators.energy import altitude_energies, energies
from hairpipe.laws.settings import StepControl
from hairpipe.shot.build import bodies_of
from hairpipe.shot.locks import advance_locked, with_particles
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.solve.stage import State
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.network import Network
from hairpipe.values import Table
from hairpipe.values.groom import Driver
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

FRAME = 1 / 24
COLUMNS = (
    "speed",
    "step [s]",
    "steps",
    "deepest [mm]",
    "deepest at a frame [mm]",
    "through the bar",
    "stretch [%]",
    "fastest [m/s]",
    "won at rest [J/kg]",
    "simulated",
    "failed",
)


def clash_table(
    truth: Table | None, run: Callable[[float, int], Worst], speeds: Sequence[float], rates: Sequence[int]
) -> Table:
    """Tabulate what becomes of hair at every speed [m/s] and every number of steps a second.

    truth  such a table of converged runs, with all these speeds, or BadInput; None: this is one
    run    drives the bar at a speed [m/s] with so many steps a second
    """
    rows = []
    known = fastest_of(truth)
    if missing := sorted({f"{speed:g} m/s" for speed in speeds} - set(known)) if known else []:
        raise BadInput(f"the converged run has no {missing[0]}", right=f"one of {', '.join(known)}")
    for speed in speeds:
        possible = FLUNG * known.get(f"{speed:g} m/s", np.inf) + FLUNG_LEAST
        for rate in rates:
            worst = run(speed, rate)
            depths = (1e3 * worst.deepest, 1e3 * worst.shown)
            through = int(worst.through.sum())
            values = *depths, through, 100 * worst.stretch, worst.fastest, worst.grown, worst.simulated
            rows.append((f"{speed:g} m/s", 1.0 / rate, worst.steps, *values, signs(worst, possible)))
    return table_of_rows(COLUMNS, rows)


def fastest_of(truth: Table | None) -> dict[str, float]:
    """Return how fast points get in converged runs [m/s], by the speed of the bar; of several runs the last counts."""
    return {} if truth is None else dict(zip(truth["speed"], truth.numbers["fastest [m/s]"].tolist(), strict=True))


def fixed_steps(rate: int) -> StepControl:
    """Return steps of one length, so many a second, however far things move in them."""
    return StepControl(1.0 / rate, np.inf, np.inf, crossings=np.inf)


def meet(hair: HairModel, scene: Scene, bar: bool, speed: float, seconds: float) -> Worst:
    """Drive the bar through the tuft at a speed [m/s]; a run that is not finite ends there."""
    state = start(hair, roots_at(hair.groom, speed, 0.0), scene)
    strands = len(hair.groom.ids)
    worst = Worst(np.zeros(strands, bool), simulated=strands)
    with np.errstate(all="ignore"):
        for frame in range(round(seconds / FRAME)):
            try:
                state = _advance(hair, state, scene, bar, speed, frame * FRAME, worst)
            except ArithmeticError:  # what is not finite has no neighbours
                worst.finite = False
            if not worst.finite:
                break
            ended = (frame + 1) * FRAME
            axis = axis_at(speed, ended)[0] if bar else None
            seen = _seen(hair, state.positions, state.velocities, axis)
            worst.end_frame(ended, seen, _energy(hair, state, roots_at(hair.groom, speed, ended)))
    return worst


def _advance(
    hair: HairModel, state: HairState, scene: Scene, bar: bool, speed: float, began: float, worst: Worst
) -> HairState:
    """Advance by a frame, and check every step of what is simulated, and at the end what guides carry."""
    times = began, began + FRAME
    drivers = roots_at(hair.groom, speed, times[0]), roots_at(hair.groom, speed, times[1])
    parts = [(bar_at(speed, times[0]), bar_at(speed, times[1]))] if bar else []
    bodies = bodies_of((), parts, scene.contact, FRAME)

    def simulate(strands: HairModel, before: HairState, drivers: tuple[Driver, Driver]) -> HairState:
        points = strands.layout.axis(before.positions)
        worst.simulated = min(worst.simulated, len(strands.groom.ids))

        def look(motion: State, *when: float) -> None:
            nonlocal points
            axes = [axis_at(speed, began + t)[0] for t in when]
            seen = _seen(strands, motion.x, motion.v, axes[1] if bar else None)
            worst.steps += 1
            worst.note(seen)
            if bar and worst.finite:
                through = passed_through(points - axes[0], seen.points - axes[1], strands.layout.offsets)
                worst.through[np.isin(hair.groom.ids, strands.groom.ids)] |= through
            points = seen.points

        return advance_frame(strands, before, drivers, bodies, FRAME, scene, began, look)

    if scene.locks is None:
        return simulate(hair, state, drivers)
    moved = advance_locked(hair, state, Frame(drivers, (), parts, began, FRAME), scene, simulate)
    if worst.finite:
        worst.note(_seen(hair, moved.positions, moved.velocities, axis_at(speed, times[1])[0] if bar else None))
    return moved


def _seen(hair: HairModel, positions: np.ndarray, velocities: np.ndarray, axis: np.ndarray | None) -> Seen:
    points = hair.layout.axis(positions)
    offsets = hair.layout.offsets
    lengths = np.delete(np.linalg.norm(np.diff(points, axis=0), axis=1), offsets[1:-1] - 1)
    return Seen(points, hair.layout.axis(velocities), float(lengths.max()) * SEGMENTS / LENGTH - 1.0, axis)


def _energy(hair: HairModel, state: HairState, driver: Driver) -> float:
    """Return the energy of motion, weight and the springs of strands [J/kg].

    Hair that is carried in a lock counts as if it stood up. What other hair holds that sticks to it, is pressed against
    it or is denser than it may be is not counted: a contact comes into being as it is pressed.
    """
    layout = hair.layout
    clamped = hair.model.shape.clamped
    state = with_particles(hair, state, driver)
    motion = State.begin(state, state.positions)
    own = energies(hair, motion, GRAVITY)
    if isinstance(hair.model, Network):
        own = own + altitude_energies(hair.model, layout, motion.x)
    masses = hair.model.mass.reshape(layout.blocks, -1, layout.width)[:, clamped:].sum(axis=1)
    return float((own / masses)[~layout.idle].mean())
