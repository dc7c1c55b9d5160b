"""Process that plays hair for one page, and ends with the connection of that page."""

import json
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from hairpipe import child
from hairpipe.page.stream import Show

MOST_BYTES = 1 << 20
"""Largest size of a read."""


class Playing:
    """A process of `stream.py`; any thread may call it, one thread reads."""

    def __init__(self, show: Show, environment: Mapping[str, str]) -> None:
        # In a session of its own: Ctrl-C is for the server, which ends its players.
        self._process = subprocess.Popen(
            child.command("from hairpipe.page.stream import main; main()"),
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
        """Write a line, unless the process has ended."""
        with suppress(OSError):
            assert self._process.stdin is not None
            self._process.stdin.write(json.dumps(document).encode() + b"\n")
            self._process.stdin.flush()
