"""What the script `hairpipe` calls: scripts that pip has written name this place, so it stays where it is."""

import os
import signal
from types import FrameType
from typing import NoReturn

__all__ = ["main"]

ERRORS, INTERRUPTED = 2, 130


def main() -> None:
    """Run the command line; Ctrl-C during the first imports ends it in one line."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, leave)
    from hairpipe.app.cli.entry import main as enter

    enter()


def leave(number: int, frame: FrameType | None) -> NoReturn:
    """End the process at once: no command has started."""
    os.write(ERRORS, b"hairpipe: interrupted\n")
    os._exit(INTERRUPTED)
