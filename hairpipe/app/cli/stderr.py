"""Messages to the user: one line each, to the standard error stream."""

import os
import sys
from contextlib import suppress

import click

from hairpipe.engine.node.messages import one_line

DESCRIPTOR = 2  # descriptor of the stream


class ClosedPipe(Exception):
    """The reader of the messages has closed the pipe."""


def echo(line: str) -> None:
    """Write a line to the standard error stream, which gets everything except results."""
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
    """Open a null stream if there is no standard error: otherwise another file would get its descriptor.

    Messages, and what workers print, would then be written into that file.
    """
    if sys.stderr is None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), DESCRIPTOR)
        os.set_inheritable(DESCRIPTOR, True)  # dup2 does not if the file already has that descriptor
        sys.stderr = os.fdopen(DESCRIPTOR, "w")
