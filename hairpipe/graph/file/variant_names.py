"""Names of variants, from the settings that differ: `force=2e-06,drag=0.5`, which can be part of a file name."""

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from hairpipe.graph.store.digest import digest_bytes

PLAIN = re.compile(r"[^\w.+-]+", re.ASCII)
MARK, MOST_LETTERS = 6, 120


def short_names(targets: Iterable[str]) -> dict[str, str]:
    """Return the shortest unique suffix of every dotted name."""
    paths = [target.split(".") for target in targets]

    def alike(path: list[str], count: int) -> int:
        return sum(other[-count:] == path[-count:] for other in paths)

    counts = [next(n for n in range(1, len(path) + 1) if n == len(path) or alike(path, n) == 1) for path in paths]
    return {".".join(path): ".".join(path[-count:]) for path, count in zip(paths, counts, strict=True)}


def variant_name(names: Mapping[str, str], settings: Mapping[str, Any]) -> str:
    """Return the name of a variant, unique for its settings and independent of other variants.

    names  short names of the settings
    """
    name = ",".join(f"{names[target]}={word(value)}" for target, value in settings.items())
    return name if len(name) <= MOST_LETTERS else f"{name[: MOST_LETTERS - MARK - 1]}-{mark(name)}"


def word(value: Any) -> str:
    """Return a value in characters of any file system; a digest is added if characters were replaced."""
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    if isinstance(value, float):
        exact = [short for digits in range(1, 18) if float(short := f"{value:.{digits}g}") == value]
        text = min(exact, key=len)
    clean = PLAIN.sub("-", text)
    return text if clean == text else f"{clean.strip('-')[:30]}-{mark(text)}"


def mark(text: str) -> str:
    """Return the beginning of the digest of a text."""
    return digest_bytes("variant", text.encode())[:MARK]
