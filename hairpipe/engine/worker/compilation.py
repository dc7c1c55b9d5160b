"""Seconds in which numba compiles in this process; kernels that are read from a file do not count."""

import time
from typing import Any

_seconds, _begun, _depth = 0.0, 0.0, 0


def seconds_compiled() -> float:
    """Return the seconds of compilation since `count_compilation`."""
    return _seconds


def count_compilation() -> None:
    """Count from now on, once a process."""
    from numba.core import event

    class Counter(event.Listener):
        def on_start(self, event: Any) -> None:
            global _begun, _depth
            _begun = _begun if _depth else time.perf_counter()
            _depth += 1

        def on_end(self, event: Any) -> None:
            global _seconds, _depth
            _depth -= 1
            if _depth == 0:  # what is compiled within another function counts with that
                _seconds += time.perf_counter() - _begun

    event.register("numba:compile", Counter())
