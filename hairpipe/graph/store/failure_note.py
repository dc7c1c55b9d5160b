"""Notes of failed evaluations in a store, for whoever plans or watches; no run depends on them.

The note of a key is made on the machine where its evaluation failed, and removed when another one starts.
"""

import json
import socket
from contextlib import suppress
from typing import NamedTuple

from hairpipe.graph.node.messages import one_line
from hairpipe.graph.store.digest import digest, parsed
from hairpipe.graph.store.store import Store


class FailureNote(NamedTuple):
    """The machine where an evaluation failed, and its message."""

    host: str
    message: str

    def __str__(self) -> str:
        """One line: `failed on render-7: ValueError: no faces`."""
        return one_line(f"failed on {self.host}: {self.message}")


def note_failure(store: Store, key: str, message: str) -> None:
    """Note that the evaluation of a key failed on this machine."""
    store.note(digest("failure", key), json.dumps([socket.gethostname(), message]))


def recall_failure(store: Store, key: str) -> FailureNote | None:
    """Read the note of a key; None where its evaluation has not failed, or another one has started since.

    Whoever may write to the store may have written something else there: None for that, too.
    """
    text = store.recall(digest("failure", key))
    with suppress(ValueError):
        match parsed(text or "null"):
            case [str(host), str(message)]:
                return FailureNote(host, message)
    return None


def forget_failure(store: Store, key: str) -> None:
    """Remove the note of a key."""
    store.forget(digest("failure", key))
