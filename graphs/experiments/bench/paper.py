"""Reproduction of Table 2 of Selle, Lentine, Fedkiw 2008: cost of a frame of the paper's scenes."""

import resource
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.store.store import Store
from hairpipe.graphs.experiments.bench.replay import Replay
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, in_seconds, make_report
from hairpipe.graphs.experiments.bench.shares import shares_of
from hairpipe.strands.registry import strand_models
from hairpipe.values.hair import HairState


class Printed(NamedTuple):
    """Values of the paper for a scene: particles, and minutes per frame on one to four machines of four processors."""

    particles: int
    minutes: float


PRINTED = {
    "long_curly": Printed(250_000, 4.0),
    "medium_straight": Printed(500_000, 10.0),
    "medium_straight_wind": Printed(500_000, 12.0),
    "long_straight_5000": Printed(500_000, 17.0),
    "long_straight_10000": Printed(1_000_000, 38.0),
}
"""Table 2 of the paper, by the name of our graph."""
STILL, FRAMES = 12, 3
"""Numbers of skipped frames, in which the head hardly moves, and of measured frames."""
HAIR, FIRST = "hair", "first frame"
"""Name of the node in all graphs; column of the first measured frame, counted from the release of the hair."""


def measure_paper(
    echo: Echo,
    scenes: dict[str, Path],
    store: Store,
    overrides: Mapping[str, str],
    settling: Sequence[int],
    threads: Sequence[int] = (),
) -> Report:
    """Measure scenes, graph files by their names, and report progress.

    store      of the inputs of hair
    overrides  settings of every scene, see `load_graph`
    settling   numbers of frames of motion before the measured ones, in turn
    threads    numbers of threads; by default all
    """
    cases, parts = list[Case](), list[Case]()
    for name, path in scenes.items():
        for case, shares in measure_scene(echo, path, store, overrides, settling, threads):
            found: Case = {"scene": name, **case, "memory so far [GB]": memory_so_far()}
            if name in PRINTED:
                printed = PRINTED[name]
                found |= {"particles in the paper": printed.particles, "frame in the paper [s]": 60.0 * printed.minutes}
            cases.append(found)
            parts.append({"scene": name, FIRST: case[FIRST], "threads": case["threads"], **in_seconds(shares)})
    tables = {"frames": cases, "parts": parts}
    serial = serial_shares(parts)
    return make_report(__name__, tables | {"serial": serial} if serial else tables)


def serial_shares(parts: Sequence[Case]) -> list[Case]:
    """Return the share of one thread's time in which further threads do not help, by part [%]; pure.

    parts  rows of `measure_paper`: those of one thread come before others of the same scene and first frame

    Amdahl's law, t_n = t_1 (s + (1 - s) / n). A second thread also waits for memory, which counts as serial. Source:
    G. M. Amdahl, Validity of the single processor approach to achieving large scale computing capabilities, 1967.
    """
    found = list[Case]()
    alone = dict[tuple, dict[str, float]]()
    for row in parts:
        times = {name: float(value) for name, value in row.items() if name.endswith(" [s]")}
        times["all [s]"] = sum(times.values())
        place = row["scene"], row[FIRST]
        count = int(row["threads"])
        if count == 1:
            alone[place] = times
        elif place in alone:
            shares = {
                name.replace("[s]", "[%]"): 100.0 * (count * seconds / alone[place][name] - 1.0) / (count - 1.0)
                for name, seconds in times.items()
                if alone[place][name] > 0.0
            }
            found.append({"scene": row["scene"], FIRST: row[FIRST], "threads": count, **shares})
    return found


def measure_scene(
    echo: Echo, path: Path, store: Store, overrides: Mapping[str, str], settling: Sequence[int], threads: Sequence[int]
) -> Iterator[tuple[Case, dict[str, float]]]:
    """Measure frames of a scene in full motion, after every number of earlier ones, with every number of threads.

    Yields the median frame, and the times of its parts [s].
    """
    graph = load_graph(path, overrides)
    graph = replace(graph, frames=(graph.frames[0] + STILL, graph.frames[1]))
    replay = Replay(graph, store, HAIR)
    name = path.stem
    echo(f"{name}: body and groom")
    replay.prepare(max(settling) + FRAMES)
    before = numba.get_num_threads()
    segments = np.diff(replay.arguments()["groom"].offsets) - 1
    shape = strand_models()[graph.nodes[HAIR].settings["model"]].shape
    counts: Case = {"strands": len(segments), "particles": sum(shape.count(int(count)) for count in segments)}
    for settled in sorted(settling):
        while (passed := replay.frame - graph.begin) < settled:
            echo(f"{name}: frame {passed + 1} of {settled} before the measured ones")
            replay.advance(replay.arguments())
        begun = (replay.frame, replay.state)
        for count in threads or (before,):
            echo(f"{name}: {FRAMES} frames on {count} threads")
            numba.set_num_threads(min(count, before))
            try:
                found = [timed_frame(replay) for _ in range(FRAMES)]
            finally:
                numba.set_num_threads(before)
            seconds, shares = sorted(found, key=lambda case: case[0])[FRAMES // 2]
            case: Case = {**counts, FIRST: settled + 1, "threads": min(count, before), "frame [s]": seconds}
            yield case | {"simulated [%]": 100.0 * simulated_share(replay.state, len(segments))}, shares
            replay.frame, replay.state = begun


def timed_frame(replay: Replay) -> tuple[float, dict[str, float]]:
    """Simulate the next frame; return its time and that of its parts [s], without other nodes."""
    arguments = replay.arguments()
    return shares_of(lambda: replay.advance(arguments))


def simulated_share(state: HairState, strands: int) -> float:
    """Return the share of simulated strands, if others are interpolated in locks."""
    return float(state.simulated(strands).mean())


def memory_so_far() -> float:
    """Return the peak memory of this process [GB]."""
    return 1024e-9 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
