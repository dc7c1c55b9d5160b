"""Cost of contact: a frame of a full head, and the share of each part."""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numba

from hairpipe.bench.machine import Machine, this_machine
from hairpipe.bench.shares import shares_of
from hairpipe.graphs.experiments.bench.core import THREADS
from hairpipe.graphs.experiments.bench.head import STEPS, Between, Head, grow_head
from hairpipe.graphs.experiments.bench.roofs import TRIAD, Roofs, measure_roofs
from hairpipe.sim.locks.grouping import follows


class Sizes(NamedTuple):
    """What is measured.

    segments  of all hair
    between   what hair does to hair
    moving    frames before the first that is measured: hair has fallen, touched and stuck by then, and is in locks
    frames    that are measured for each number of threads
    triad     numbers in each array of the triad
    seconds   that the roofs are measured for
    """

    segments: tuple[int, ...] = (10_000, 100_000, 1_000_000)
    between: tuple[Between, ...] = ("pairs", "locks", "volume")
    moving: int = 20
    frames: int = 3
    triad: int = TRIAD
    seconds: float = 1.0


FULL = Sizes()


class Case(NamedTuple):
    """A frame of one head on so many threads.

    particles  of the strands, including those off their axes
    simulated  share of the strands that are at the end, where others follow in locks
    seconds    a frame, the median
    shares     of the parts of the work, in seconds of that frame
    stuck      connections by stiction at the end
    """

    segments: int
    between: Between
    particles: int
    simulated: float
    threads: int
    seconds: float
    shares: dict[str, float]
    stuck: int


class Report(NamedTuple):
    """All of it; steps are those of a frame of 1/24 s."""

    machine: Machine
    sizes: Sizes
    steps: int
    roofs: Roofs
    cases: list[Case]


def measure_contact(say: Callable[[str], None], sizes: Sizes = FULL) -> Report:
    """Measure every case, and report progress."""
    threads = [count for count in THREADS if count <= numba.get_num_threads()]
    say("multiply-adds and the triad")
    roofs = measure_roofs(("float64",), threads, sizes.triad, sizes.seconds)
    cases = []
    for segments, between in product(sizes.segments, sizes.between):
        named = f"{segments:,} segments, {between} between hairs"
        say(f"{named}: growing them")
        head = grow_head(segments, between)
        for frame in range(sizes.moving):
            say(f"{named}: frame {frame + 1} of {sizes.moving} before the measured ones")
            head.advance(head.surroundings())
        begun = head.state, head.frame
        for count in threads:
            head.state, head.frame = begun
            say(f"{named}: {sizes.frames} frames on {count} threads")
            numba.set_num_threads(count)
            try:
                found = [_timed(head) for _ in range(sizes.frames)]
            finally:
                numba.set_num_threads(threads[-1])
            seconds, shares = sorted(found, key=lambda case: case[0])[len(found) // 2]
            layout, state = head.hair.layout, head.state
            grown = int(layout.offsets[-1]) - len(layout.offsets) + 1
            simulated = 1.0 if state.locks is None else float((~follows(state.locks.leaders)).mean())
            cases.append(Case(grown, between, layout.particles, simulated, count, seconds, shares, len(state.stuck)))
    return Report(this_machine(), sizes, STEPS, roofs, cases)


def _timed(head: Head) -> tuple[float, dict[str, float]]:
    """Simulate a frame; returns its time and that of its parts [s], without what other nodes of a graph make."""
    frame = head.surroundings()
    return shares_of(lambda: head.advance(frame))
