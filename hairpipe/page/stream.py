"""Plays a graph in a process of its own, for a page: settings come in as lines, frames go out as bytes.

A frame is the length of its head, the head as JSON, and the places of its points in steps of a box: what `packing.py`
does to save bytes would cost more time here than the bytes do.
"""

import json
import os
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np

import hairpipe
from hairpipe.api.shot import Player, Shot, played_nodes
from hairpipe.data import Strands
from hairpipe.errors import BadInput
from hairpipe.page.packing import quantised
from hairpipe.page.shapes import thinned

SLOWEST_LOOK = 1.0
"""Time after which one that failed is tried again [s]: settings may have changed."""


@dataclass(frozen=True)
class Show:
    """What to play: a node of a graph with settings.

    output  of it, hair
    most    strands that are shown
    """

    graph: str
    settings: dict[str, Any]
    cache: str
    node: str
    output: str
    most: int


class Settings:
    """The latest settings, which arrive as lines while frames are made; the end of the lines ends the process."""

    def __init__(self, first: dict[str, Any]) -> None:
        self._latest = first
        self._new = False
        threading.Thread(target=self._listen, daemon=True).start()

    def changed(self) -> dict[str, Any] | None:
        """Return settings that came since the last call; None where none did."""
        found = self._latest if self._new else None
        self._new = False
        return found

    def _listen(self) -> None:
        for line in sys.stdin:
            self._latest = json.loads(line)
            self._new = True
        os._exit(0)


def main() -> None:
    """Read what to play from the input, and write frames until the input ends."""
    show = Show(**json.loads(sys.stdin.readline()))
    settings = Settings(show.settings)
    base = hairpipe.load(show.graph, cache=show.cache)
    player: Player | None = None
    wanted = show.settings
    while True:
        begun = time.perf_counter()
        try:
            if player is None:
                player = base.changed(wanted).player(show.node)
            elif (new := settings.changed()) is not None:
                wanted = new
                player.take(base.changed(wanted).graph)
            send(sys.stdout.buffer, player, show)
        except Exception as fault:  # a node may raise anything: the page says it, and it may be put right there
            what = str(fault) if isinstance(fault, BadInput) else f"{type(fault).__name__}: {fault}"
            write(sys.stdout.buffer, {"fault": what}, b"")
            wanted = settings.changed() or wanted
            time.sleep(SLOWEST_LOOK)
        time.sleep(max(0.0, begun + 1.0 / base.fps - time.perf_counter()))


def send(out: BinaryIO, player: Player, show: Show) -> None:
    """Play a frame, and write it."""
    played = player.advance()
    hair = played.values[show.output]
    if not isinstance(hair, Strands):
        raise BadInput("is not hair", where=f"{show.node}.{show.output}", right="an output of strands")
    shown, lengths, kept = thinned(hair.offsets, show.most)
    places, box = quantised(hair.points[kept])
    head = {
        "frame": played.frame,
        "seconds": played.seconds,
        "lengths": lengths.tolist(),
        "strands": shown.tolist() if len(shown) < len(hair.offsets) - 1 else None,
        "total": len(hair.offsets) - 1,
        "diameter": hair.diameter,
        **box,
    }
    write(out, head, places.astype("<u2").tobytes())


def write(out: BinaryIO, head: dict[str, Any], body: bytes) -> None:
    """Write a message: lengths of head and body, head, body."""
    text = json.dumps(head).encode()
    out.write(np.array([len(text), len(body)], "<u4").tobytes() + text + body)
    out.flush()


def playable(shot: Shot) -> list[str]:
    """Name the nodes of a shot that can be played: hair that a simulation leads to, whatever is in the cache."""
    names = []
    for name, node in shot.nodes.items():
        if Strands in node.type.outputs.values():
            try:
                played_nodes(shot.graph.upto([name]), name)
                names.append(name)
            except BadInput:
                continue
    return names
