"""Process that plays hair for one page, and ends with the connection of that page.

It reads the text of the graph as lines, and writes frames as bytes: the length of the head, the head as JSON, and the
places of points in steps of a box; compression as in `values.py` would take more time than it saves.
"""

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np

from hairpipe import child
from hairpipe.app.api.draft import load_draft
from hairpipe.app.api.shot import Player, Shot, played_nodes
from hairpipe.app.page.values import quantised, thinned, width_steps
from hairpipe.errors import BadInput
from hairpipe.values import Strands

SLOWEST_LOOK = 1.0  # time to retry a failed frame [s]: settings may have changed


@dataclass(frozen=True)
class Show:
    """A node of a graph to play, with the edited text of the graph."""

    graph: str
    text: str
    cache: str
    node: str
    output: str  # output of the node, hair
    most: int  # maximum number of shown strands


class Settings:
    """Latest text of the graph, which is read as lines while frames are made; the end of the input ends the process."""

    def __init__(self, first: str) -> None:
        self._latest = first
        self._new = False
        threading.Thread(target=self._listen, daemon=True).start()

    def changed(self) -> str | None:
        found = self._latest if self._new else None
        self._new = False
        return found

    def _listen(self) -> None:
        for line in sys.stdin:
            self._latest = json.loads(line)
            self._new = True
        os._exit(0)


def main() -> None:
    show = Show(**json.loads(sys.stdin.readline()))
    settings = Settings(show.text)
    shot = load_draft(show.graph, show.text, cache=show.cache).shot
    player: Player | None = None
    wanted = show.text
    while True:
        begun = time.perf_counter()
        try:
            if player is None:
                player = load_draft(show.graph, wanted, cache=show.cache).shot.player(show.node)
            elif (new := settings.changed()) is not None:
                wanted = new
                player.take(load_draft(show.graph, wanted, cache=show.cache).shot.graph)
            send(sys.stdout.buffer, player, show)
        except Exception as fault:  # a node may raise any exception: the page shows it, and settings may correct it
            what = str(fault) if isinstance(fault, BadInput) else f"{type(fault).__name__}: {fault}"
            write(sys.stdout.buffer, {"fault": what}, b"")
            wanted = settings.changed() or wanted
            time.sleep(SLOWEST_LOOK)
        time.sleep(max(0.0, begun + 1.0 / shot.fps - time.perf_counter()))


def send(out: BinaryIO, player: Player, show: Show) -> None:
    played = player.advance()
    hair = played.values[show.output]
    if not isinstance(hair, Strands):
        raise BadInput("is not hair", where=f"{show.node}.{show.output}", right="an output of strands")
    shown, lengths, kept = thinned(hair.offsets, show.most)
    places, box = quantised(hair.points[kept])
    widest, widths = width_steps(hair, kept)
    head = {
        "frame": played.frame,
        "seconds": played.seconds,
        "lengths": lengths.tolist(),
        "strands": shown.tolist() if len(shown) < len(hair.offsets) - 1 else None,
        "total": len(hair.offsets) - 1,
        "diameter": widest,
        **box,
    }
    write(out, head, places.astype("<u2").tobytes() + (b"" if widths is None else widths.tobytes()))


def write(out: BinaryIO, head: dict[str, Any], body: bytes) -> None:
    """Write a message: lengths of head and body, head, body."""
    text = json.dumps(head).encode()
    out.write(np.array([len(text), len(body)], "<u4").tobytes() + text + body)
    out.flush()


def playable(shot: Shot) -> list[str]:
    """List the nodes of a shot that can be played: hair after a simulation, independent of the cache."""
    names = []
    for name, node in shot.nodes.items():
        if Strands in node.type.outputs.values():
            try:
                played_nodes(shot.graph.upto([name]), name)
                names.append(name)
            except BadInput:
                continue
    return names


MOST_BYTES = 1 << 20  # largest size of a read


class Playing:
    """A process that plays; any thread may call it, one thread reads."""

    def __init__(self, show: Show, environment: Mapping[str, str]) -> None:
        # In a session of its own: Ctrl-C is for the server, which ends its players.
        self._process = subprocess.Popen(
            child.command("from hairpipe.app.page.playing import main; main()"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
            start_new_session=True,
        )
        self._write(vars(show))

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.poll() is not None

    def take(self, text: str) -> None:
        """Set the text of the graph of the next frames."""
        self._write(text)

    def read(self) -> bytes:
        """Wait for more bytes of messages; empty after the end."""
        assert self._process.stdout is not None
        return self._process.stdout.read1(MOST_BYTES)  # type: ignore[union-attr]

    def close(self) -> None:
        """End the process; a waiting `read` returns."""
        self._process.kill()
        self._process.wait()

    def _write(self, document: Any) -> None:
        with suppress(OSError):
            assert self._process.stdin is not None
            self._process.stdin.write(json.dumps(document).encode() + b"\n")
            self._process.stdin.flush()
