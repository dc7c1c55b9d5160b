"""Cost of contact: a frame of a full head, and the share of each part."""

from itertools import product

import numba

from hairpipe.graphs.experiments.bench.core import THREADS
from hairpipe.graphs.experiments.bench.head import Between, Head, grow_head
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, in_seconds, make_report
from hairpipe.graphs.experiments.bench.roofs import measure_roofs
from hairpipe.graphs.experiments.bench.shares import shares_of

SEGMENTS = (10_000, 100_000, 1_000_000)
"""Of all hair."""
BETWEEN: tuple[Between, ...] = ("pairs", "locks", "volume")
"""What hair does to hair."""


def measure_contact(
    echo: Echo,
    segments: tuple[int, ...] = SEGMENTS,
    between: tuple[Between, ...] = BETWEEN,
    moving: int = 20,
    frames: int = 3,
) -> Report:
    """Measure every case, and report progress.

    segments  of all hair
    between   what hair does to hair
    moving    frames before the first that is measured: hair has fallen, touched and stuck by then, and is in locks
    frames    that are measured for each number of threads
    """
    threads = [count for count in THREADS if count <= numba.get_num_threads()]
    echo("multiply-adds and the triad")
    roofs = measure_roofs(("float64",), threads)
    cases: list[Case] = []
    parts: list[Case] = []
    for wanted, kind in product(segments, between):
        named = f"{wanted:,} segments, {kind} between hairs"
        echo(f"{named}: growing them")
        head = grow_head(wanted, kind)
        for frame in range(moving):
            echo(f"{named}: frame {frame + 1} of {moving} before the measured ones")
            head.advance(head.surroundings())
        begun = head.state, head.frame
        for count in threads:
            head.state, head.frame = begun
            echo(f"{named}: {frames} frames on {count} threads")
            numba.set_num_threads(count)
            try:
                found = [_timed(head) for _ in range(frames)]
            finally:
                numba.set_num_threads(threads[-1])
            seconds, shares = sorted(found, key=lambda case: case[0])[len(found) // 2]
            case: Case = {"segments": segments_of(head), "between": kind, "threads": count}
            cases.append({**case, "frame [s]": seconds, **counts_of(head)})
            parts.append({**case, **in_seconds(shares)})
    return make_report(__name__, {"frames": cases, "parts": parts, "limits": roofs.cases}, roofs.bandwidth)


def segments_of(head: Head) -> int:
    """Count the segments of all hair."""
    offsets = head.hair.layout.offsets
    return int(offsets[-1]) - len(offsets) + 1


def counts_of(head: Head) -> Case:
    """Count the particles, including those off the axes, the simulated strands, and connections by stiction."""
    simulated = float(head.state.simulated(len(head.hair.groom.ids)).mean())
    return {
        "particles": head.hair.layout.particles,
        "simulated [%]": 100.0 * simulated,
        "connections": len(head.state.stuck),
    }


def _timed(head: Head) -> tuple[float, dict[str, float]]:
    """Simulate a frame; returns its time and that of its parts [s], without what other nodes of a graph make."""
    frame = head.surroundings()
    return shares_of(lambda: head.advance(frame))
