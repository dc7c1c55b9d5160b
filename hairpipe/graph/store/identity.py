"""The identity of a store: a random name within, by which machines find out whether they see the same one.

A path says nothing: on another machine it may lead to an empty folder, or to the store of another project.
"""

import re
import secrets
import time
from contextlib import suppress
from pathlib import Path

from hairpipe.graph.store.atomic import write_text
from hairpipe.graph.store.digest import digest
from hairpipe.graph.store.lease import Leases
from hairpipe.graph.store.store import Store

CLAIM = digest("identity", "")
"""Key of the lease of whoever gives a store its identity: two may find none at one time."""
PAUSE = 0.05
"""Time until the identity that another gives is looked for again [s]."""
_NAME = re.compile(r"[0-9a-f]{32}")


def identity_of(root: Path) -> str | None:
    """Read the identity of a store; None where it has none."""
    with suppress(OSError, UnicodeDecodeError):
        text = (root / "id").read_text(encoding="utf-8").strip()
        return text if _NAME.fullmatch(text) else None
    return None


def claim_identity(store: Store) -> str:
    """Read the identity of a store, which is given one if it has none; OSError where that cannot be written."""
    leases = Leases(store)
    while (known := identity_of(store.root)) is None:
        if leases.acquire(CLAIM):
            if identity_of(store.root) is None:
                write_text(store.room(store.root / "id"), secrets.token_hex(16), store.temporary)
            leases.release(CLAIM)
        else:
            time.sleep(PAUSE)
    return known
