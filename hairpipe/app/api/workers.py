"""The workers of this user that outlive runs: their number, and their end."""

from collections.abc import Iterator
from contextlib import closing, suppress

from hairpipe.engine.hosts.keeper import SUFFIX, Message, connected, receive, runtime_folder, send


def kept_workers() -> list[tuple[int, float]]:
    """Return the number of idle workers, and the time until their end [s], for every program of this user."""
    return [(answer["count"], answer["left"]) for answer in answers("count")]


def end_workers() -> int:
    """End the idle workers of this user; return their number."""
    return sum(answer["count"] for answer in answers("end"))


def answers(verb: str) -> Iterator[Message]:
    """Send a request to every keeper of this user, and yield their answers; those that do not answer are omitted."""
    for path in sorted(runtime_folder().glob(f"*{SUFFIX}")):
        channel = connected(path)
        if channel is not None:
            with closing(channel), suppress(OSError, EOFError):
                send(channel, {"verb": verb})
                yield receive(channel)[0]
