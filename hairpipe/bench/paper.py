"""Table 2 of Selle, Lentine, Fedkiw 2008 again: what a frame of each of the paper's scenes costs."""

import resource
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.bench.machine import Machine, this_machine
from hairpipe.bench.replay import Replay
from hairpipe.bench.shares import shares_of
from hairpipe.data.hair import HairState
from hairpipe.graph.file.load import load_graph
from hairpipe.graph.store.store import Store
from hairpipe.sim.strands.registry import strand_models


class Printed(NamedTuple):
    """What the paper says of a scene: particles, and minutes a frame on one to four machines of four processors."""

    particles: int
    minutes: float


PRINTED = {
    "long_curly": Printed(250_000, 4.0),
    "medium_straight": Printed(500_000, 10.0),
    "medium_straight_wind": Printed(500_000, 12.0),
    "long_straight_5000": Printed(500_000, 17.0),
    "long_straight_10000": Printed(1_000_000, 38.0),
}
"""Its Table 2, by the name of our graph."""
STILL, FRAMES = 12, 3
"""Frames that are skipped, since the head hardly moves; that are measured."""
HAIR = "hair"
"""Name of the node in all graphs."""


class Row(NamedTuple):
    """A frame of one scene.

    particles  of the strands, including those off their axes
    simulated  share of the strands that are, where others follow in locks
    seconds    the median; shares  of the parts of the work, in seconds of that frame
    memory     the most that this process had until then [bytes]
    printed    what the paper has; None for a scene that it has not
    """

    scene: str
    strands: int
    particles: int
    simulated: float
    seconds: float
    shares: dict[str, float]
    memory: int
    printed: Printed | None


class Report(NamedTuple):
    """All scenes."""

    machine: Machine
    rows: list[Row]


def measure_paper(
    say: Callable[[str], None], scenes: dict[str, Path], cache: Path, overrides: Mapping[str, str], settling: int
) -> Report:
    """Measure scenes, graph files by their names, and report progress.

    cache      folder in which what hair depends on is kept
    overrides  settings of every scene, see `load_graph`
    settling   frames of motion before those that are measured
    """
    store = Store(cache)
    rows = [measure_scene(say, name, path, store, overrides, settling) for name, path in scenes.items()]
    return Report(this_machine(), rows)


def measure_scene(
    say: Callable[[str], None],
    name: str,
    path: Path,
    store: Store,
    overrides: Mapping[str, str],
    settling: int,
) -> Row:
    """Measure some frames of a scene, in which the head is in full motion."""
    graph = load_graph(path, overrides)
    graph = replace(graph, frames=(graph.frames[0] + STILL, graph.frames[1]))
    replay = Replay(graph, store, HAIR)
    say(f"{name}: body and groom")
    replay.prepare(settling + FRAMES)
    for frame in range(settling):
        say(f"{name}: frame {frame + 1} of {settling} before the measured ones")
        replay.advance(replay.arguments())
    found: list[tuple[float, dict[str, float]]] = []
    states: list[HairState] = []
    segments = np.diff(replay.arguments()["groom"].offsets) - 1
    for frame in range(FRAMES):
        say(f"{name}: frame {frame + 1} of {FRAMES}")
        arguments = replay.arguments()
        found.append(shares_of(lambda given=arguments: states.append(replay.advance(given).state)))
    seconds, shares = sorted(found, key=lambda case: case[0])[FRAMES // 2]
    shape = strand_models()[graph.nodes[HAIR].settings["model"]].shape
    particles = sum(shape.count(int(count)) for count in segments)
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    locks = states[-1].locks
    simulated = 1.0 if locks is None else len(np.unique(locks.leaders)) / len(segments)
    return Row(name, len(segments), particles, simulated, seconds, shares, memory, PRINTED.get(name))
