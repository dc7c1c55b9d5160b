"""What a run leaves: results, objects and published files, as digests that are compared."""

from collections.abc import Callable
from pathlib import Path

from hairpipe.engine.plan.maintenance import Found, items, verify
from hairpipe.engine.store.digest import digest, digest_bytes
from hairpipe.engine.store.store import Store

CheckValue = Callable[[Path], str]
"""Gives the digest of the value in a file, as for `verify`."""


def state_of(folder: Path, out: Path, check_value: CheckValue) -> dict[str, str]:
    """Digest what is in a store and what was published, and name what is damaged in the store.

    folder  of the store
    out     folder of published files
    """
    store = Store(folder, read_only=True)
    found = verify(store, check_value)
    known = sorted(
        (item.record.key, sorted((n, o.object) for n, o in item.record.outputs.items())) for item in items(store)
    )
    files = sorted((str(path.relative_to(out)), digest_of(path)) for path in out.rglob("*") if path.is_file())
    return {
        "results": digest("results", known),
        "objects": digest("objects", sorted(store.object_names())),
        "published files": digest("published", files),
        "damages": "" if found == Found() else str(found),
    }


def digest_of(path: Path) -> str:
    """Digest the bytes of a file."""
    return digest_bytes("file", path.read_bytes())


def differences(state: dict[str, str], other: dict[str, str]) -> list[str]:
    """Name what differs; pure."""
    return [f"other {name}" for name in state if state[name] != other[name]]
