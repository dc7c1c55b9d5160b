"""Fails in the ways that nodes fail."""

import errno
import os
import signal
import time as clock
from pathlib import Path
from typing import Literal

from numeral import Numeral
from tally import numeral, tally

from hairpipe.engine import Time, node
from hairpipe.errors import BadInput


@node(frames="each")
def go_wrong(
    number: Numeral,
    time: Time,
    *,
    at: int = 3,
    how: Literal["raise", "input", "kill", "full", "type", "slow"] = "raise",
) -> Numeral:
    """Fail at a frame."""
    tally("go_wrong", time.frame)
    if time.frame == at:
        if how == "raise":
            raise ZeroDivisionError("no strands left")
        if how == "input":
            raise BadInput("not a clip", where="walk.bvh:7")
        if how == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if how == "full":
            raise OSError(errno.ENOSPC, "No space left on device")
        if how == "type":
            return 3.0
        if how == "slow":
            wait()
    return numeral(number.value)


def wait():
    """Wait for a minute, or until there is the file that TOY_GATE names."""
    gate = Path(os.environ.get("TOY_GATE", "/nowhere"))
    end = clock.monotonic() + 60
    while clock.monotonic() < end and not gate.exists():
        clock.sleep(0.02)
