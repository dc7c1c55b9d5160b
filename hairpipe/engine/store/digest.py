"""Digests: the canonical JSON under each of them, and the keys of actions.

An action is one evaluation of a node. Its inputs enter its key by the content of their values: a re-run upstream that
gives equal values changes no key below it.
"""

import json
import math
import re
from hashlib import blake2b
from typing import Any

DIGEST_BYTES = 20
DIGEST = re.compile(rf"[0-9a-f]{{{2 * DIGEST_BYTES}}}")
"""A digest as text."""

Parts = dict[str, Any]
"""All that the result of an action depends on: type, code, settings, inputs, time; see `hairpipe.engine.plan.key`."""


def canonical(value: Any) -> str:
    """Write a value as JSON with sorted keys; 1, 1.0, true and "1" stay four different texts.

    Raises TypeError for anything but None, bool, int, float, str, list, tuple and dict with text keys, and
    ValueError for NaN and infinity: they have no canonical text.
    """
    check(value)
    return json.dumps(value, sort_keys=True, separators=(",", ":"))


def check(value: Any) -> None:
    """Refuse what JSON would silently turn into something else."""
    kind = type(value)
    if kind is dict:
        if any(type(name) is not str for name in value):
            raise TypeError(f"keys of a canonical value are text: {value!r}")
        value = value.values()
    elif kind is float and not math.isfinite(value):
        raise ValueError(f"{value} has no canonical text")
    elif kind not in (list, tuple):
        if value is not None and kind not in (str, int, float, bool):
            raise TypeError(f"no canonical text for {value!r}")
        return
    for item in value:
        check(item)


def parsed(text: str | bytes) -> Any:
    """Read JSON that somebody else may have written; ValueError for whatever is none."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def digest(kind: str, value: Any) -> str:
    """Digest a canonical value; `kind` keeps digests of different things apart."""
    return digest_bytes(kind, canonical(value).encode())


def digest_bytes(kind: str, data: bytes) -> str:
    """Digest bytes; `kind` keeps digests of different things apart."""
    return hasher(kind, data).hexdigest()


def hasher(kind: str, data: bytes = b"") -> "blake2b":
    """Begin a digest of this kind."""
    return blake2b(data, digest_size=DIGEST_BYTES, person=kind.encode())


def action_key(parts: Parts) -> str:
    """Digest the parts into the name under which the store knows the result."""
    return digest("action", parts)


def is_key(text: Any) -> bool:
    """Whether something is the key of an action: it becomes part of a path."""
    return isinstance(text, str) and DIGEST.fullmatch(text) is not None
