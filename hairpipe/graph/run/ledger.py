"""Record of published files: it distinguishes files that hairpipe may replace from those of the user.

It lies in a folder of the user, since the store may be deleted or exchanged. A line is added for each written file;
the last line of a name is valid, and a damaged line is ignored.
"""

import json
import os
from contextlib import suppress
from pathlib import Path

from hairpipe.graph.store.atomic import replacing
from hairpipe.graph.store.digest import digest_bytes, parsed
from hairpipe.graph.store.ownership import fault_of, make_own, own_folder

SPARE = 4
"""Lines per name beyond which a ledger is rewritten, with one line for each."""


class Ledger:
    """Digests of published files; empty, without an error, where the user has no home folder."""

    def __init__(self) -> None:
        self._known: dict[Path, dict[str, str]] = {}

    def digest(self, place: Path) -> str | None:
        """Digest of the bytes last published to a place; None where there are none."""
        return self._names(place.parent).get(place.name)

    def note(self, place: Path, digest: str) -> None:
        """Record that bytes with this digest were published to a place."""
        names = self._names(place.parent)
        if names.get(place.name) != digest:
            names[place.name] = digest
            with suppress(OSError):
                append(ledger_path(place.parent), f"\n{json.dumps([place.name, digest])}")

    def _names(self, folder: Path) -> dict[str, str]:
        if folder not in self._known:
            self._known[folder] = {}
            with suppress(OSError):
                self._known[folder] = read(ledger_path(folder))
        return self._known[folder]


def ledger_path(folder: Path) -> Path:
    """Path of the ledger of a folder."""
    return own_folder("state") / "published" / digest_bytes("published", os.fsencode(folder))


def read(path: Path) -> dict[str, str]:
    """Read digests by name, and drop superseded lines; nothing is read from a file that others may have written.

    OSError where it cannot be read.
    """
    names: dict[str, str] = {}
    text = b"" if fault_of(path.parent) or fault_of(path) or not path.exists() else path.read_bytes()
    lines = text.decode(errors="replace").splitlines()
    for line in lines:
        with suppress(ValueError):
            match parsed(line):
                case [str(name), str(digest)]:
                    names[name] = digest
    if len(lines) > SPARE * (len(names) + 1):
        with suppress(OSError), replacing(path) as temporary:
            temporary.write_text("".join(f"\n{json.dumps(pair)}" for pair in names.items()), encoding="utf-8")
            temporary.chmod(0o600)
    return names


def append(path: Path, line: str) -> None:
    """Add a line in one write, so that several processes may do so at once."""
    make_own(path.parent)
    handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    try:
        os.write(handle, line.encode())
    finally:
        os.close(handle)
