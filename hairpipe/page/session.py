"""A live page: a shot with edits that are not saved yet, the plan of it, and the run that goes on."""

import json
import os
import signal
import subprocess
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hairpipe import child
from hairpipe.api.reports import STATUSES, Status, Task
from hairpipe.api.selection import FrameSet, read_frames
from hairpipe.api.shot import Shot
from hairpipe.errors import BadInput
from hairpipe.graph.file.overrides import parse_value
from hairpipe.page.documents import RunOutput, graph_document, state_document, wedge_document
from hairpipe.page.packing import Packed
from hairpipe.page.playing import Playing
from hairpipe.page.runner import Job
from hairpipe.page.shelf import Shelf
from hairpipe.page.stream import Show, playable

MOST_STRANDS = 4000
"""That are drawn of a groom."""
PAUSE = 0.7
"""Time between two looks at the cache and at the graph file [s]; longer where a look takes long."""
Message = dict[str, Any]
"""What a run has said last, see `runner.py`."""


class Session:
    """Everything behind a live page. Any thread may call it.

    frames    that a run computes and the plan is of; None for all
    wedge     of the graph, whose variants are shown and run
    revision  counts the changes of what the page shows
    """

    def __init__(self, shot: Shot, frames: FrameSet = None, wedge: str | None = None) -> None:
        self._wedge = wedge
        self._base = shot
        self.frames = None if frames is None else list(shot.graph.select(read_frames(frames)))
        self._edits: dict[str, str] = {}
        self._shot = shot
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._run: subprocess.Popen[str] | None = None
        self._statuses: dict[Task, Status] = {}
        self._ended: Message = {}
        self._stopped = False
        self._players: list[Playing] = []
        self._note = ""
        self._seen: Any = None
        self.revision = 0
        self._shelf = Shelf(MOST_STRANDS)
        self._take(shot, {})
        self._open = True
        threading.Thread(target=self._follow, daemon=True).start()

    def close(self) -> None:
        """Stop the run that this page began, and following."""
        self._open = False
        self.stop()
        for player in self._players:
            player.close()
        with self._changed:
            self._changed.notify_all()

    def wait(self, seen: int, most: float) -> int:
        """Wait until there is something newer than a revision, at most so long [s]; returns the latest revision.

        It does not wait once the session is closed.
        """
        with self._changed:
            self._changed.wait_for(lambda: self.revision > seen or not self._open, most)
            return self.revision

    def document(self, name: str) -> Packed:
        """Make a document by name; KeyError for an unknown one, BadInput for one that has gone from the cache."""
        with self._lock:
            if name == "graph":
                return graph_document(self._shot) | self._live(), b""
            if name == "state":
                return self._state(), b""
            if name == "wedge" and self._wedge is not None:
                return self._variants(), b""
            return self._shelf.document(name)

    def picture(self, name: str) -> tuple[bytes, str]:
        """Read a picture and its suffix; KeyError for an unknown name."""
        with self._lock:
            return self._shelf.picture(name), self._shelf.suffix(name) or ""

    def edit(self, target: str, text: str) -> None:
        """Change a setting, as `--set` does; BadInput where the graph does not take it, and nothing is changed."""
        with self._lock:
            self._take(self._base, self._edits | {target: text})

    def revert(self) -> None:
        """Forget all edits."""
        with self._lock:
            self._take(self._base, {})

    def save(self) -> None:
        """Write the edits into the graph file, and nothing else; BadInput where it is a shipped graph or in the way."""
        with self._lock:
            self._base.save({target: parse_value(text) for target, text in self._edits.items()})
            self._edits = {}
            self._reload()

    def run(self, to: list[str]) -> None:
        """Begin a run of the graph with its edits; BadInput where one goes on."""
        with self._lock:
            if self._run is not None:
                raise BadInput("a run is in progress", where=self._base.path.name, right="wait for its end, or stop it")
            settings = {target: parse_value(text) for target, text in self._edits.items()}
            job = Job(self._base.given, settings, self.frames, to, str(self._base.cache), self._wedge)
            self._run = subprocess.Popen(
                child.command("from hairpipe.page.runner import main; main()"),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                env=child.environment(),
            )
            assert self._run.stdin is not None
            self._run.stdin.write(job.text + "\n")
            self._run.stdin.flush()
            self._statuses = {}
            self._ended = {}
            self._note = ""
            self._stopped = False
            threading.Thread(target=self._listen, args=(self._run,), daemon=True).start()
            self._advance()

    def stop(self) -> None:
        """Interrupt the run that goes on: what it has computed is kept."""
        with self._lock:
            if self._run is not None and self._run.poll() is None:
                self._stopped = True
                # One that has said nothing yet has no workers, and may not listen to an interrupt yet.
                self._run.send_signal(signal.SIGINT if self._statuses else signal.SIGTERM)

    def play(self, node: str, output: str) -> Playing:
        """Begin to play a node, with the settings as they are edited from now on; whoever reads it closes it.

        BadInput where kernels have no safe place.
        """
        with self._lock:
            settings = {target: parse_value(text) for target, text in self._edits.items()}
            show = Show(self._base.given, settings, str(self._base.cache), node, output, MOST_STRANDS)
            player = Playing(show, self._shot.playing_environment())
            self._players = [*(other for other in self._players if not other.ended), player]
            return player

    def explain(self, node: str, frame: int | None) -> str:
        """Say what a result is made of, and how that differs from the latest one; BadInput for an unknown one."""
        with self._lock:
            found = self._shot.explain(f"{node}@{frame}" if frame is not None else node, frames=self.frames)
        made = json.dumps(found.parts, indent=1, sort_keys=True) if found.parts else ""
        return "\n".join([found.entry.status, *found.reasons, made])

    def _live(self) -> dict[str, Any]:
        """Actions of the page besides display."""
        return {"edits": dict(self._edits), "saved": self._can_save(), "playable": playable(self._shot)}

    def _can_save(self) -> bool:
        return self._base.given == str(self._base.path) and os.access(self._base.path, os.W_OK)

    def _state(self) -> dict[str, Any]:
        if self._wedge is not None:  # what is run is the wedge
            return state_document(self._shot, self._plan, self._shelf.suffix) | {"wedge": True}
        document = state_document(self._shot, self._plan, self._shelf.suffix, RunOutput(self._statuses, {}))
        return {"nodes": document["nodes"], "verdict": document["verdict"] | self._running(), "wedge": False}

    def _variants(self) -> dict[str, Any]:
        """Describe the wedge, as it is with the edits."""
        assert self._wedge is not None
        wedge = self._shot.wedge(self._wedge)
        found = wedge.plan(self.frames)
        self._shelf.take(wedge, found)
        document = wedge_document(wedge, found, self._shelf.suffix, RunOutput(self._statuses, {}), self.frames)
        return document | {"verdict": document["verdict"] | self._running()}

    def _running(self) -> dict[str, Any]:
        """Describe the run that goes on, or how the last one ended."""
        ended = {name: value for name, value in self._ended.items() if name != "kind"}
        return ended | {"running": self._run is not None, "note": self._note}

    def _take(self, base: Shot, edits: Mapping[str, str]) -> None:
        """Plan a shot with edits, and show it from now on; BadInput changes nothing."""
        shot = base.changed({target: parse_value(text) for target, text in edits.items()})
        plan = shot.plan(self.frames)
        self._base = base
        self._edits = dict(edits)
        self._shot = shot
        self._plan = plan
        for player in self._players:
            player.take({target: parse_value(text) for target, text in edits.items()})
        self._shelf.take(shot, plan)
        self._advance()

    def _advance(self) -> None:
        with self._changed:
            self.revision += 1
            self._changed.notify_all()

    def _reload(self) -> None:
        """Read the graph file again; what is wrong with it is noted, and the page stays as it was."""
        try:
            self._take(self._base.reloaded(), self._edits)
            self._note = ""
        except BadInput as fault:
            self._note = str(fault)
            self._advance()

    def _follow(self) -> None:
        """Look at the cache and at the graph file from time to time: anyone may change them."""
        while self._open:
            begun = time.monotonic()
            seen = (
                stamp(self._base.path),
                *(stamp(path) for path in sorted((self._base.cache / "actions").glob("??"))),
            )
            if seen != self._seen:
                with self._lock:
                    if self._seen is not None:
                        self._reload()
                    self._seen = seen
            time.sleep(max(PAUSE, 2.0 * (time.monotonic() - begun)))

    def _listen(self, run: "subprocess.Popen[str]") -> None:
        """Take in what a run says until it ends."""
        assert run.stdout is not None
        for line in run.stdout:
            message = json.loads(line)
            with self._lock:
                if message["kind"] == "ended":
                    self._ended = message
                elif message["kind"] in STATUSES:
                    self._statuses[Task(message["node"], message["frame"])] = STATUSES[message["kind"]]
                self._advance()
        run.wait()
        with self._lock:
            if not self._ended:
                died = [] if self._stopped else [f"the run ended with exit code {run.returncode}"]
                self._ended = {"failures": died, "interrupted": self._stopped}
            self._run = None
            self._statuses = {task: status for task, status in self._statuses.items() if status != "running"}
            self._reload()


def stamp(path: Path) -> tuple[int, int]:
    """Time and size of a file or folder by which a change is seen; zeros where there is none."""
    try:
        found = path.stat()
    except OSError:
        return (0, 0)
    return (found.st_mtime_ns, found.st_size)
