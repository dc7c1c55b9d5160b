"""Cost of a frame of hair: some frames of a shot are simulated again, on one thread, and timed."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numba
import numpy as np

from hairpipe.data import BodyParts, Ends, LevelSet, Mesh, Particles, Table
from hairpipe.data.hair import HairState
from hairpipe.data.particles import ParticleState
from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.particles.settings import ParticleSettings
from hairpipe.particles.simulate import ParticleFrame, prepare
from hairpipe.particles.simulate import next_state as next_particles
from hairpipe.sim.boundary import lead_of
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.settings import HairSettings
from hairpipe.sim.simulate import Frame, next_state

Advance = Callable[[Any, tuple[int, int]], Any]
"""Returns the state of hair at the second of two frames, of that at the first, or of None where it starts there.

ArithmeticError where it is not finite.
"""
COLUMNS = ("seconds per frame", "fastest frame [s]", "slowest frame [s]", "frames timed", "particles")


class Around(NamedTuple):
    """The surroundings of hair, frame by frame; None or empty where there are none.

    cuts  frames at which the shot is cut
    """

    body: Mapping[int, Mesh] | None
    ends: Mapping[int, Ends] | None
    surfaces: Sequence[Mapping[int, LevelSet]]
    parts: Sequence[Mapping[int, BodyParts]]
    cuts: Sequence[int] = ()

    def frames(self, first: int, count: int) -> list[int]:
        """List frames, at most so many of those there are; they are counted on from the first where nothing moves.

        Raises BadInput where one is left out among them.
        """
        known = [some for some in (self.body, self.ends, *self.surfaces, *self.parts) if some is not None]
        if not known:
            return list(range(first, first + count))
        frames = list(known[0])[:count]
        for before, after in pairwise(frames):
            if after != before + 1:
                what = f"no frames between {before} and {after}, and a simulation goes from frame to frame"
                raise BadInput(what, where="frames", right=f"{count} of them in a row")
        return frames


def cost_table(advance: Advance, frames: Sequence[int], particles: int, warm: int, timed: int) -> Table:
    """Return one row: what a frame took [s], the median, the fastest and the slowest, and the number of particles.

    advance  from frame to frame: `hair_advance`, `particle_advance`
    frames   in a row
    warm     frames that do not count: kernels are compiled, hair falls and meets what is in its way
    timed    frames after those; of a shot without any, its last one counts

    Seconds are those of the processor in this process, on one thread: what other processes do is not counted. A run
    that is no longer finite ends there. All is NaN where there is no frame to be timed.
    """
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        seconds = list(_seconds(advance, frames))
    finally:
        numba.set_num_threads(threads)
    seconds = seconds[min(warm, max(len(seconds) - 1, 0)) :]
    counted = seconds[-timed:] if seconds else [np.nan]
    row = (float(np.median(counted)), min(counted), max(counted), len(seconds[-timed:]), particles)
    return table_of_rows(COLUMNS, [row])


def _seconds(advance: Advance, frames: Sequence[int]) -> Iterator[float]:
    """Simulate frames and return the time of each but the first [s], up to the first frame that is not finite."""
    state = None
    for pair in zip([frames[0], *frames], frames, strict=False):
        begun = time.process_time()
        try:
            with np.errstate(all="ignore"):
                after = advance(state, pair)
        except ArithmeticError:  # where hair touches hair, what is not finite is found within a frame
            return
        if state is not None:
            yield time.process_time() - begun
        state = after


def hair_advance(hair: HairModel, around: Around, settings: HairSettings, dt: float) -> Advance:
    """Return what simulates strands from frame to frame, dt [s] apart."""

    def advance(state: HairState | None, pair: tuple[int, int]) -> HairState:
        after = next_state(hair, state, frame_between(around, pair, dt), settings)
        if not np.isfinite(after.positions).all():
            raise ArithmeticError("hair is not finite")
        return after

    return advance


def particle_advance(particles: Particles, around: Around, settings: ParticleSettings, dt: float) -> Advance:
    """Return what simulates loosely connected particles from frame to frame, dt [s] apart."""
    prepared = prepare(particles, settings)

    def advance(state: ParticleState | None, pair: tuple[int, int]) -> ParticleState:
        leads = _at(around.body, pair) or (None, None)
        bodies = [_pair(some, pair) for some in around.surfaces], [_pair(some, pair) for some in around.parts]
        frame = ParticleFrame(leads, *bodies, (pair[1] - 1) * dt, dt, pair[1] in around.cuts)
        return next_particles(particles, prepared, state, frame, settings)

    return advance


def frame_between(around: Around, pair: tuple[int, int], dt: float) -> Frame:
    """Collect what hair is given at the second of two frames, dt [s] apart."""
    leads = lead_of(_at(around.body, pair), _at(around.ends, pair)) or (None, None)
    bodies = [_pair(some, pair) for some in around.surfaces], [_pair(some, pair) for some in around.parts]
    return Frame(leads, *bodies, (pair[1] - 1) * dt, dt, pair[1] in around.cuts)


def _pair(values: Mapping[int, object], pair: tuple[int, int]) -> tuple:
    """Read a value at two frames."""
    return values[pair[0]], values[pair[1]]


def _at(values: Mapping[int, object] | None, pair: tuple[int, int]) -> tuple | None:
    """Read a value at two frames, where there is one."""
    return None if values is None else _pair(values, pair)
