"""Messages to the user: one line each, to the standard error stream."""

import os
import sys
from contextlib import suppress

import click

from hairpipe.graph.node.messages import one_line

DESCRIPTOR = 2
"""Of the stream, by convention of all systems."""


class ClosedPipe(Exception):
    """Nobody reads the messages: the other end of the pipe is closed."""


def echo(line: str) -> None:
    """Write a line to the standard error stream, which takes everything except results."""
    try:
        click.echo(one_line(line), err=True)
    except BrokenPipeError:
        raise ClosedPipe from None
    except OSError:
        pass  # a full disk under a log does not end a run


def fail(message: str, code: int) -> None:
    """Report a fault, and end with this exit code."""
    with suppress(ClosedPipe):
        echo(f"hairpipe: {message}")
    sys.exit(code)


def open_stderr() -> None:
    """Discard errors if there is no stream for them: otherwise an opened file would get its number.

    Messages, and what workers print, would then be written into that file.
    """
    if sys.stderr is None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), DESCRIPTOR)
        os.set_inheritable(DESCRIPTOR, True)  # where the file got that number at once, dup2 has done nothing
        sys.stderr = os.fdopen(DESCRIPTOR, "w")
