"""The identity of a store: a random name within, by which machines find out whether they see the same one.

A path says nothing: on another machine it may lead to an empty folder, or to the store of another project.
"""

import re
import secrets
from contextlib import suppress
from pathlib import Path

from hairpipe.graph.store.atomic import replacing

_NAME = re.compile(r"[0-9a-f]{32}")


def identity_of(root: Path) -> str | None:
    """Read the identity of a store; None where it has none."""
    with suppress(OSError, UnicodeDecodeError):
        text = (root / "id").read_text(encoding="utf-8").strip()
        return text if _NAME.fullmatch(text) else None
    return None


def claim_identity(root: Path) -> str:
    """Read the identity of a store, which is given one if it has none; OSError where that cannot be written."""
    while (known := identity_of(root)) is None:
        root.mkdir(parents=True, exist_ok=True)
        with replacing(root / "id") as file:
            file.write_text(secrets.token_hex(16), encoding="utf-8")
    return known
