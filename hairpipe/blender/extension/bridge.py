"""`hairpipe bridge` as a child process: requests and events are lines of JSON, see docs/reference/bridge.md.

Nothing here waits: a thread reads the events, and `events` gives those that have arrived.
"""

import json
import os
import queue
import subprocess
import threading
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from shutil import which
from typing import Any

PROTOCOL = 1
NAMES = ("hairpipe", "Scripts/hairpipe.exe", "bin/hairpipe")
"""Where the program may be within a folder that the user states: an environment, or its folder of programs."""
Event = dict[str, Any]


class Absent(Exception):
    """There is no hairpipe, it does not start, or it speaks another protocol; the message says what to do."""


def find_program(stated: str, own: Path) -> str:
    """Return the path of hairpipe: as stated, a file or a folder, or in our own environment, or in the PATH.

    The variable HAIRPIPE of the environment states it for one run. Raises Absent where there is none.
    """
    stated = os.environ.get("HAIRPIPE", stated)
    if stated:
        path = Path(stated).expanduser()
        found = [path] if path.is_file() else [path / name for name in NAMES if (path / name).is_file()]
        if not found:
            raise Absent(f"{path}: there is no hairpipe; state its path in the preferences of the extension")
        return os.fspath(found[0])
    in_own = [own / name for name in NAMES if (own / name).is_file()]
    program = os.fspath(in_own[0]) if in_own else which("hairpipe")
    if program is None:
        raise Absent("hairpipe is not found: state its path in the preferences of the extension, or install it there")
    return program


def version_of(program: str) -> str:
    """Return what `hairpipe version` prints; Absent where it fails."""
    try:
        done = subprocess.run([program, "version"], capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired) as fault:
        raise Absent(f"{program} does not start: {fault}") from None
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise Absent(f"{program} fails: {last}")
    return done.stdout.strip()


class Bridge:
    """One process of hairpipe that answers requests in turn."""

    def __init__(self, program: str) -> None:
        """Start it; Absent where that fails."""
        hidden = getattr(subprocess, "CREATE_NO_WINDOW", 0)
        try:
            self.process = subprocess.Popen(
                [program, "bridge"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                encoding="utf-8",
                creationflags=hidden,
                env=environment(),
            )
        except OSError as fault:
            raise Absent(f"{program} does not start: {fault}") from None
        self.numbers = count(1)
        self.arrived: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self.complaints: list[str] = []
        for read in (self._read_events, self._read_complaints):
            threading.Thread(target=read, daemon=True).start()

    def _read_events(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            try:
                self.arrived.put(json.loads(line))
            except ValueError:
                self.complaints.append(line)
        self.arrived.put({"event": "ended", "id": None})

    def _read_complaints(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.complaints = [*self.complaints[-50:], line.rstrip()]

    def ask(self, do: str, **fields: Any) -> int:
        """Send a request; return its number. Absent where the process has ended."""
        number = next(self.numbers)
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps({"id": number, "do": do, **fields}) + "\n")
            self.process.stdin.flush()
        except OSError:
            raise Absent(f"hairpipe has ended: {self.last_words()}") from None
        return number

    def events(self) -> Iterator[Event]:
        """Give the events that have arrived; Absent where the process has ended, or speaks another protocol."""
        while True:
            try:
                event = self.arrived.get_nowait()
            except queue.Empty:
                return
            if event["event"] == "hello" and event.get("protocol") != PROTOCOL:
                what = f"hairpipe {event.get('hairpipe')} speaks protocol {event.get('protocol')}"
                raise Absent(f"{what}, and this extension protocol {PROTOCOL}: install the extension of that version")
            if event["event"] == "ended":
                raise Absent(f"hairpipe has ended: {self.last_words()}")
            yield event

    def last_words(self) -> str:
        return next((line for line in reversed(self.complaints) if line.strip()), "it says nothing")

    def is_alive(self) -> bool:
        return self.process.poll() is None

    def close(self) -> None:
        """End the process; what it has computed is kept."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        try:
            self.process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self.process.kill()


def environment() -> dict[str, str]:
    """Return our environment without what Blender sets for its own Python."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONPATH")}
