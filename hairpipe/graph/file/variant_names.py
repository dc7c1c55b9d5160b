"""Names of variants, from the settings that differ: `force=2e-06,drag=0.5`, which can be part of a file name."""

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from hairpipe.graph.store.digest import digest_bytes

PLAIN = re.compile(r"[^\w.+-]+", re.ASCII)
MARK, MOST_LETTERS = 6, 120


def short_names(targets: Iterable[str]) -> dict[str, str]:
    """Name every setting by as few of the last of its dotted names as tell it from the others."""
    paths = [target.split(".") for target in targets]

    def alike(path: list[str], count: int) -> int:
        return sum(other[-count:] == path[-count:] for other in paths)

    counts = [next(n for n in range(1, len(path) + 1) if n == len(path) or alike(path, n) == 1) for path in paths]
    return {".".join(path): ".".join(path[-count:]) for path, count in zip(paths, counts, strict=True)}


def variant_name(names: Mapping[str, str], settings: Mapping[str, Any]) -> str:
    """Name a variant after its settings; distinct for distinct settings, the same whatever other variants there are.

    names  of the settings, short
    """
    name = ",".join(f"{names[target]}={word(value)}" for target, value in settings.items())
    return name if len(name) <= MOST_LETTERS else f"{name[: MOST_LETTERS - MARK - 1]}-{mark(name)}"


def word(value: Any) -> str:
    """Write a value in letters that every file system takes; where that changes it, with a digest of it."""
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    if isinstance(value, float):
        exact = [short for digits in range(1, 18) if float(short := f"{value:.{digits}g}") == value]
        text = min(exact, key=len)
    clean = PLAIN.sub("-", text)
    return text if clean == text else f"{clean.strip('-')[:30]}-{mark(text)}"


def mark(text: str) -> str:
    """Return the beginning of the digest of a text."""
    return digest_bytes("variant", text.encode())[:MARK]
