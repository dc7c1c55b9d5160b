"""The only place where the key of an action is made.

An action is one evaluation of a node. Its inputs enter by the content of their values: a re-run upstream that gives
equal values changes no key below it.
"""

from typing import Any

from hairpipe.graph.store.digest import DIGEST, digest

Parts = dict[str, Any]


def key_parts(
    type_name: str, code: str, settings: dict[str, Any], inputs: dict[str, Any], time: dict[str, Any] | None
) -> Parts:
    """Gather all that a result depends on.

    settings  checked values; a file is there by the digest of its bytes
    inputs    by socket, or `socket.0` ...: a digest, [previous, current], [[frame, digest], ...] or None
    time      frame and fps where the node asks for them, else None
    """
    return {"type": type_name, "code": code, "settings": settings, "inputs": inputs, "time": time}


def action_key(parts: Parts) -> str:
    """Digest the parts into the name under which the store knows the result."""
    return digest("action", parts)


def is_key(text: Any) -> bool:
    """Whether something is the key of an action: it becomes part of a path."""
    return isinstance(text, str) and DIGEST.fullmatch(text) is not None
