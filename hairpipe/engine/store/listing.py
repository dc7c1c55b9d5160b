"""A file with companions in the store: which object has which name. The listing is named by its content."""

import json
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any
from unicodedata import category

from hairpipe.engine.store.atomic import reopening
from hairpipe.engine.store.digest import digest, parsed
from hairpipe.engine.store.record import is_object
from hairpipe.engine.store.store import LostObject, Store

MOST_BYTES = 64 << 20
"""Of a listing: about a million companions [bytes]."""


@dataclass(frozen=True)
class Listing:
    """Objects of a file and of what must lie next to it.

    path        object of the file itself
    companions  objects by relative name; ValueError for one that would lead out of the folder of the file
    """

    path: str
    companions: dict[str, str]

    def __post_init__(self) -> None:
        for label in self.companions:
            check_name(label)

    @property
    def name(self) -> str:
        """Name of the object that the listing is."""
        return digest("set", self._plain) + ".set"

    @property
    def text(self) -> str:
        """The listing as it is stored."""
        return json.dumps(self._plain)

    @property
    def _plain(self) -> dict[str, Any]:
        return {"path": self.path, "companions": self.companions}


def read_listing(store: Store, name: str) -> Listing:
    """Read a listing of a store; LostObject, and it is removed, where it is not there or not what its name says."""
    path = store.object_path(name)
    found = parse_listing(path) if store.has(name) else None
    if found is None or found.name != name:
        store.remove(path)
        raise LostObject(name)
    return found


@reopening
def parse_listing(path: Path) -> Listing | None:
    """Read a file as a listing; None where it is none. Only its name tells that it is as written."""
    try:
        with path.open("rb") as file:
            fields = parsed(file.read(MOST_BYTES))
        listing = Listing(fields["path"], dict(fields["companions"]))
    except (FileNotFoundError, ValueError, TypeError, KeyError):
        return None
    names = [listing.path, *listing.companions.values()]
    whole = fields.keys() == {"path", "companions"} and isinstance(fields["companions"], dict)
    return listing if whole and all(is_object(name, ".bin") for name in names) else None


def check_name(label: str) -> None:
    """Refuse the name of a companion that would lead out of the folder of its file, or that hides where it leads."""
    path = PurePosixPath(label)
    is_plain = bool(path.parts) and not path.is_absolute() and ".." not in path.parts and str(path) == label
    if not is_plain or any(category(letter) in ("Cc", "Cs") for letter in label):
        raise ValueError(f"companion {label!r} is not a relative name")
