"""Session of a live page: a shot with unsaved edits, its plan, and the active run."""

import json
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from hairpipe.app.api.cache import Cache
from hairpipe.app.api.draft import Draft, load_draft
from hairpipe.app.api.reports import Entry, Plan, Task
from hairpipe.app.api.selection import FrameSet, read_frames
from hairpipe.app.api.shot import Shot
from hairpipe.app.page.documents import (
    RunOutput,
    catalogue_document,
    draft_document,
    machine_document,
    nodes_document,
    state_document,
    wedge_document,
)
from hairpipe.app.page.edits import Edit, History, copy_assets, edited, write_stroke
from hairpipe.app.page.playing import Playing, Show, playable
from hairpipe.app.page.runs import Job, Request, Runs
from hairpipe.app.page.values import Packed, Shelf
from hairpipe.errors import BadInput

MOST_STRANDS = 4000  # number of drawn strands of a groom at most, unless the page asks for another one
CHEAP, MOST_COOKED = 20.0, 24  # largest time [s] and number of results that the page computes by itself
PAUSE = 0.7
"""Interval of polling the cache and the graph file [s], at once after a result of a run; longer if polling is slow."""


class Session:
    """State of a live page; any thread may call it.

    frames    frames of runs and of the plan; None for all
    wedge     wedge whose variants are shown and run
    draft     the graph file with its edits
    revision  number of changes of the page
    drawn     number of the last change of the graph, or of its edits
    closed    whether the session was closed
    """

    def __init__(self, given: Shot | Draft, frames: FrameSet = None, wedge: str | None = None) -> None:
        draft = given if isinstance(given, Draft) else load_draft(given.given, cache=given.cache)
        shot = self._shot = draft.shot
        self._seen = self._look()  # before the file is read: later changes are noticed
        self._wedge = wedge
        self._history = History(draft.text, draft.read_file())
        self.frames = None if frames is None else list(shot.graph.select(read_frames(frames)))
        self.draft = draft
        self._lock = threading.RLock()
        self._listeners: set[Callable[[], object]] = set()
        self._woken = threading.Event()
        self._runs = Runs(self._lock, self._announce, self._woken.set, self._replan)
        self._players: list[Playing] = []
        self._note = self._lost = ""  # faults of the file, and of the plan
        self._cache = Cache(shot.cache)
        self._hosts: Mapping[Task, str] = {}
        self._made: list[Path] = []  # images of strokes, and copies of files of templates
        self._costs: dict[str, float] = {}
        self._cooked: tuple[str, str, int] | None = None  # text, node and frame of the last run by itself
        self.revision = self.drawn = 0
        self._shelf = Shelf(MOST_STRANDS)
        self._take(draft)
        self.closed = False
        threading.Thread(target=self._follow, daemon=True).start()

    def close(self) -> None:
        """Stop the run of this page, its process, and polling."""
        self.closed = True
        self._woken.set()
        with self._lock:
            self._runs.stop()
            self._runs.close()
        for player in self._players:
            player.close()
        for call in tuple(self._listeners):
            call()
        self._remove_made()

    def _remove_made(self) -> None:
        """Remove the files that the page has made and no graph file next to this one names."""
        saved = ""
        with suppress(OSError):
            for path in self._made and self._shot.path.parent.glob("*.toml"):
                saved += path.read_text(errors="replace")
            for path in self._made:
                if path.name not in saved:
                    path.unlink(missing_ok=True)

    @contextmanager
    def heard(self, call: Callable[[], object]) -> Iterator[None]:
        """Call a function, from any thread, after every change of the page, and when the session is closed."""
        self._listeners.add(call)
        try:
            yield
        finally:
            self._listeners.discard(call)

    def document(self, name: str, most: int | None = None) -> Packed:
        """Make a document by name; KeyError for an unknown one, BadInput for one removed from the cache.

        most  maximum number of shown strands
        """
        with self._lock:
            if name == "graph":
                path = self._shot.path
                can_save = not self.draft.shipped and os.access(path if path.exists() else path.parent, os.W_OK)
                live = {"saved": can_save, "playable": playable(self._shot), "revision": self.drawn}
                return draft_document(self.draft) | self._history.document() | live, b""
            if name == "catalogue":
                return catalogue_document(self._shot.path), b""
            if name == "state":
                return self._state(), b""
            if name == "wedge" and self._wedge is not None:
                return self._variants(self._wedge), b""
        return self._shelf.document(name, most)  # without the lock: edits do not wait for the packing of hair

    def picture(self, name: str) -> tuple[bytes, str]:
        """Read a picture and its suffix; KeyError for an unknown name."""
        with self._lock:
            return self._shelf.picture(name), self._shelf.suffix(name) or ""

    def edit(self, target: str, text: str) -> None:
        """Change a setting, as `--set`; BadInput, without a change, for a setting that the graph refuses."""
        self.change("edit", {"target": target, "text": text})

    def change(self, verb: str, given: dict[str, Any]) -> None:
        """Edit the graph, see `edits.py`; BadInput, without a change, for an edit that the graph refuses."""
        with self._lock:
            text, label = edited(self.draft, verb, given)
            if text != self._history.text:
                self._take(self.draft.with_text(text))
                self._history.push(Edit(label, text, (verb, given)))
                self._advance()

    def stroke(self, given: dict[str, Any]) -> None:
        """Write a painted picture next to the graph, for a setting to read it; BadInput as `write_stroke`."""
        with self._lock:
            file = write_stroke(self.draft, given)
            self._made.append(self._shot.path.parent / file)
            self.change("paint", {"target": given["target"], "file": file})

    def begin(self, name: str) -> None:
        """Begin an empty graph with a shipped one, whose files are copied next to it; BadInput as `copy_assets`."""
        with self._lock:
            edited(self.draft, "template", {"name": name})  # refused before anything is copied
            files = copy_assets(self.draft, name)
            self._made += [self._shot.path.parent / file for file in files]
            self.change("template", {"name": name, "files": files})

    def undo(self, by: int = -1) -> None:
        """Undo the last edit, or do it again for 1; BadInput if there is none."""
        with self._lock:
            self._take(self.draft.with_text(self._history.seek(by)))
            self._history.at += by
            self._advance()

    def revert(self) -> None:
        """Discard all edits, which can be undone; a conflict ends with the text of the file."""
        with self._lock:
            history = self._history
            file = history.disk if history.theirs is None else history.theirs
            self._push("revert", history.first if file is None else file, base=file)
            self._advance()

    def save(self) -> None:
        """Write the graph file; BadInput for a shipped graph, one that another program changed, or no permission."""
        with self._lock:
            try:
                self.draft.save(self._history.disk)
            except BadInput:
                if self.draft.read_file() != self._history.disk:
                    self._reload()
                raise
            self._written()

    def save_as(self, name: str) -> None:
        """Write a new file within the project, which is the file of the page then; BadInput as `Draft.saved_as`."""
        with self._lock:
            self._take(self.draft.saved_as(name))
            self._written()

    def _written(self) -> None:
        """Note that the file has the text of the page: what it names stays, also if another file is written later."""
        self._history.written(self.draft.text)
        self._made = [path for path in self._made if path.name not in self.draft.text]
        self._advance()

    def resolve(self, keep: str) -> None:
        """End a conflict: keep the text of the `page`, take that of the `file`, or repeat `both` edits."""
        with self._lock:
            theirs = self._history.theirs
            if theirs is None or keep not in ("page", "file", "both"):
                raise BadInput("no conflict", right="page, file or both")
            if keep == "both":
                text = self._history.repeated(lambda text, deed: edited(self.draft.with_text(text), *deed)[0])
                self._push("edits of this page", text, base=theirs)
            elif keep == "file":
                self._push("changed by another program", theirs, base=theirs)
            self._history.disk, self._history.theirs = theirs, None
            self._advance()

    def _push(self, label: str, text: str, base: str | None = None) -> None:
        """Show a text as a new step; BadInput, without a change, for a faulty one."""
        if text != self._history.text:
            self._take(self.draft.with_text(text))
            self._history.push(Edit(label, text))
        if base is not None and base == text:
            self._history.written(text)

    def run(self, to: list[str]) -> None:
        """Begin a run of the graph with its edits, or let it wait for others; BadInput for one that waits already."""
        with self._lock:
            job = Job(self._shot.given, self.draft.text, self.frames, to, str(self._shot.cache), self._wedge)
            edits = self._history.deeds()
            self._runs.add(Request(job, edits[-1].label if edits else self._shot.path.name, self._shot.program))
            self._note, self._costs = "", {}
            self._announce()

    def work(self, node: str, frame: int) -> dict[str, Any]:
        """Describe the missing results up to a node, at all frames and at one; BadInput for an unknown one.

        `reason` says why `cook` does not compute the latter; it is empty where it does.
        """
        with self._lock:
            whole, now = (self._shot.plan(frames, to=[node]) for frames in (self.frames, [frame]))
            left, missing = whole.missing, now.missing
            counts = dict(Counter(entry.task.node for entry in left))
            reason = self._reason(self._shot, self._plan, missing)
            return {"counts": counts, "seconds": self._seconds(left), "now": len(missing), "reason": reason}

    def _reason(self, shot: Shot, plan: Plan, missing: Plan) -> str:
        """Return why missing results of a shot are not computed unasked; empty where they are."""
        keys = {entry.task: entry.key for entry in plan}
        scans = {e.task.node for e in missing if shot.nodes[e.task.node].type.mode == "scan"}
        if scans:
            return f"simulation {', '.join(sorted(scans))}"
        if any(keys.get(entry.task) != entry.key for entry in missing):
            return "other frames"
        costly = (self._seconds(missing) or 0.0) > CHEAP or len(missing) > MOST_COOKED
        return f"{len(missing)} results" if costly else ""

    def _seconds(self, missing: Plan) -> float | None:
        names = {entry.task.node for entry in missing}
        self._costs |= self._shot.costs(names - self._costs.keys())
        return sum(self._costs[e.task.node] for e in missing) if names <= self._costs.keys() else None

    def cook(self, node: str, frame: int) -> None:
        """Begin to compute a node at a frame, once for each text, in place of an earlier such run.

        Nothing begins during a run that somebody has asked for; BadInput for work that is not cheap.
        """
        with self._lock:
            missing = self._shot.plan([frame], to=[node]).missing
            self._cook(self.draft, self._plan, missing, node, frame)

    def _cook(self, draft: Draft, plan: Plan, missing: Plan, node: str, frame: int) -> None:
        cooked = draft.text, node, frame
        if not missing or self._runs.asked or self._cooked == cooked or self._wedge is not None:
            return
        reason = self._reason(draft.shot, plan, missing)
        if reason:
            raise BadInput(reason, where=node, right="run")
        self._cooked = cooked
        job = Job(draft.shot.given, draft.text, [frame], [node], str(draft.shot.cache), None, quiet=True)
        self._runs.add(Request(job, f"{node}@{frame}", draft.shot.program))
        self._announce()

    def trial(self, target: str, text: str, node: str, frame: int) -> dict[str, Any]:
        """Begin to compute a node at a frame with another value of a setting, as `cook`; the graph is not changed.

        `nodes` describes the results, once all are there; `begun` says whether they are being computed.
        BadInput for a value that the graph refuses, and for work that is not cheap.
        """
        with self._lock:
            draft = self.draft.with_text(edited(self.draft, "edit", {"target": target, "text": text})[0])
            now = draft.shot.plan([frame], to=[node])
            missing = now.missing
            if missing:
                self._cook(draft, draft.shot.plan(self.frames), missing, node, frame)
                return {"begun": self._cooked == (draft.text, node, frame) and self._runs.document()["running"]}
            self._shelf.take(draft.shot, now)
            return {"nodes": nodes_document(draft.shot, now, self._shelf.suffix, RunOutput({}, {}))}

    def stop(self) -> None:
        """Interrupt the active run, whose results are kept; those that wait are dropped."""
        with self._lock:
            self._runs.stop()
            self._announce()

    def drop(self, number: int) -> None:
        """Remove a waiting run by its number; BadInput where there is none."""
        with self._lock:
            self._runs.drop(number)
            self._announce()

    def play(self, node: str, output: str, most: int | None = None) -> Playing:
        """Begin to play a node with the edited settings, also with later edits; the reader closes the process.

        BadInput without a safe folder for kernels.
        """
        with self._lock:
            most = MOST_STRANDS if most is None else most
            show = Show(self._shot.given, self.draft.text, str(self._shot.cache), node, output, most)
            player = Playing(show, self._shot.playing_environment())
            self._players = [*(other for other in self._players if not other.ended), player]
            return player

    def explain(self, node: str, frame: int | None) -> str:
        """Describe the inputs of a result, and differences to the latest one; BadInput for an unknown result."""
        with self._lock:
            found = self._shot.explain(f"{node}@{frame}" if frame is not None else node, frames=self.frames)
        made = json.dumps(found.parts, indent=1, sort_keys=True) if found.parts else ""
        return "\n".join([found.entry.status, *found.reasons, made])

    def _state(self) -> dict[str, Any]:
        wedge = self._wedge is not None  # runs are of the wedge
        output = RunOutput({}, {}, self._cache.hosts(self._plan)) if wedge else self._output(self._plan)
        document: dict[str, Any] = state_document(self._shot, self._plan, self._shelf.suffix, output)
        document["wedge"] = wedge
        if not wedge:
            document["verdict"] |= self._run_state()
        for name in self.draft.tables:
            document["nodes"].setdefault(name, {"cells": []})
        return document

    def _variants(self, name: str) -> dict[str, Any]:
        wedge = self._shot.wedge(name)
        plan = wedge.plan(self.frames)
        self._shelf.take(wedge, plan)
        self._watched = (*self._plan, *plan)
        document = wedge_document(wedge, plan, self._shelf.suffix, self._output(plan), self.frames)
        return document | {"verdict": document["verdict"] | self._run_state()}

    def _output(self, plan: Plan) -> RunOutput:
        job = self._runs.job
        tried = job is not None and job.quiet and job.edited != self.draft.text
        return RunOutput({} if tried else self._runs.statuses, {}, self._cache.hosts(plan))

    def _run_state(self) -> dict[str, Any]:
        runs = self._runs.document()
        if runs["running"]:
            missing = {entry.task.node for entry in self._plan.missing}
            self._costs |= self._shot.costs(missing - self._costs.keys())
        note = self._note or self._lost
        return runs | {"costs": self._costs, "machine": machine_document(self._shot.cache), "note": note}

    def _take(self, draft: Draft) -> None:
        plan = draft.shot.plan(self.frames)
        self.draft, self._shot, self._plan = draft, draft.shot, plan
        self._watched: Iterable[Entry] = plan
        for player in self._players:
            player.take(draft.text)
        self._shelf.take(draft.shot, plan)
        self._lost = ""

    def _advance(self) -> None:
        """Announce a change of the graph."""
        with self._lock:
            self.drawn = self.revision + 1
            self._announce()

    def _announce(self) -> None:
        """Announce a change of the results, or of the graph."""
        with self._lock:
            self.revision += 1
        for call in tuple(self._listeners):
            call()

    def _replan(self) -> None:
        try:
            self._take(self.draft)
        except BadInput as fault:
            self._lost = str(fault)
        self._announce()

    def _reload(self) -> None:
        """Read the graph file again; a fault is noted, and a change in conflict with edits changes nothing else."""
        history = self._history
        try:
            text = self.draft.read_file()
            if text is None:
                history.disk = None
            elif text == history.disk:
                self._take(self.draft.with_text(self.draft.text))
            elif history.text in (history.disk, text):
                self._push("changed by another program", text, base=text)
            else:
                history.theirs = text
            self._note = ""
        except BadInput as fault:
            self._note = str(fault)
        self._advance()

    def _look(self) -> tuple[tuple[int, int], list[tuple[int, int]]]:
        """Return stamps of the graph file, and of the folders of results in the cache."""
        folders = sorted((self._shot.cache / "actions").glob("??"))
        return stamp(self._shot.path), [stamp(path) for path in folders]

    def _follow(self) -> None:
        """Poll the cache, its leases and the graph file, which other processes may change."""
        while not self.closed:
            begun = time.monotonic()
            woken = self._woken.is_set()
            self._woken.clear()
            seen = self._look()
            with self._lock:
                if self._seen[0] != seen[0]:
                    self._reload()
                elif self._lost or self._seen != seen:
                    self._replan()
                elif woken:
                    self._announce()
                self._seen = seen
                hosts = self._cache.hosts(self._watched)
                if hosts != self._hosts:
                    self._hosts = hosts
                    self._announce()
                self._runs.rest()
            spent = time.monotonic() - begun
            time.sleep(2.0 * spent)
            self._woken.wait(max(0.0, PAUSE - 2.0 * spent))


def stamp(path: Path) -> tuple[int, int]:
    """Return time and size of a file or folder, to detect changes; zeros for a missing one."""
    try:
        found = path.stat()
    except OSError:
        return (0, 0)
    return (found.st_mtime_ns, found.st_size)
