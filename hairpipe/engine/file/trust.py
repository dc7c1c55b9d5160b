"""Trust in folders of nodes: these are code, which is imported only after the user has confirmed it.

Trust covers the bytes of all importable files of a folder, independent of its location, and is recorded in a folder of
the user. Our own nodes, and those of installed packages, are trusted.
"""

import json
import os
import shlex
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.machinery import BYTECODE_SUFFIXES, all_suffixes
from pathlib import Path

from hairpipe.engine.node.import_paths import EXPERIMENTS, OUR_NODES, folder_of
from hairpipe.engine.node.messages import listed
from hairpipe.engine.store.atomic import replacing
from hairpipe.engine.store.digest import digest_bytes
from hairpipe.engine.store.fingerprint import digest_file
from hairpipe.engine.store.ownership import fault_of, make_own, own_folder
from hairpipe.errors import BadInput

VARIABLE = "HAIRPIPE_TRUST"
"""Lists absolute paths of folders that are trusted with any content: for farms, and for authors of nodes."""
CACHED = "__pycache__"
NATIVE = {".so", ".dylib", ".dll"}
"""Suffixes of libraries that an extension module may load, also within a name such as `libfast.so.1`."""

Files = Mapping[str, str]
"""Digests of the code in a folder, by path within it."""

_granted: list[Files] = []
"""Code that this process trusts on behalf of its coordinator."""


class Untrusted(BadInput):
    """Code to import is not trusted, or has changed since.

    folder  folder of the code
    files   files to trust
    """

    def __init__(self, folder: Path, files: Files, what: str) -> None:
        right = f"hairpipe trust {shlex.quote(os.fspath(folder))}, after reading the code"
        super().__init__(what, where=folder, right=right)
        self.folder, self.files = folder, files


@dataclass(frozen=True)
class Trusted:
    """A trusted folder, and its content at that time."""

    folder: Path
    files: Files

    @property
    def changed(self) -> list[str]:
        return differing(self.files, code_in(self.folder))


def trust_error(folder: Path) -> Untrusted | None:
    """Return the error for a folder that is not trusted, else None; BadInput if it cannot be read."""
    folder = folder.resolve()
    named = (Path(path) for path in os.environ.get(VARIABLE, "").split(os.pathsep))
    if folder in {*shipped_folders(), *(path.resolve() for path in named if path.is_absolute())}:
        return None
    fault = fault_of_register()
    known = list(trusted())
    files = code_in(folder)
    if not files or files in _granted or any(entry.files == files for entry in known):
        return None
    before = next((entry.files for entry in known if entry.folder == folder), None)
    if fault:
        return Untrusted(folder, files, f"the code is not trusted: {fault}")
    if before is None:
        return Untrusted(folder, files, f"the code is not trusted: {listed(list(files))}")
    return Untrusted(folder, files, f"the code has changed since it was trusted: {listed(differing(before, files))}")


def grant(files: Files) -> None:
    """Trust code in this process alone, on behalf of its coordinator."""
    if files not in _granted:
        _granted.append(files)


def trust(folder: Path, files: Files) -> None:
    """Record that these files in a folder are trusted; OSError or BadInput if the record cannot be written."""
    path = entry_path(folder)
    make_own(path.parent)
    fault = fault_of_register()
    if fault:
        raise BadInput(fault, right="a folder that you alone can write to: chmod -R go-w")
    with replacing(path) as temporary:
        text = json.dumps({"folder": os.fspath(folder.resolve()), "files": dict(files)}, indent=2)
        temporary.write_text(text, encoding="utf-8")
        temporary.chmod(0o600)


def revoke(folder: Path) -> bool:
    """Withdraw trust from a folder and its copies; returns whether it was trusted."""
    files = code_in(folder.resolve())
    gone = [entry.folder for entry in trusted() if entry.folder == folder.resolve() or entry.files == files]
    for other in gone:
        entry_path(other).unlink(missing_ok=True)
    return bool(gone)


def trusted() -> Iterator[Trusted]:
    """Iterate over the trusted folders; records that other users can write are ignored."""
    try:
        paths = [] if fault_of_register() else sorted(register().glob("*.json"))
    except OSError:
        return
    for path in paths:
        with suppress(OSError, ValueError, TypeError, KeyError, AttributeError):
            if fault_of(path) is None:
                entry = json.loads(path.read_text(encoding="utf-8"))
                yield Trusted(Path(entry["folder"]), {str(name): str(file) for name, file in entry["files"].items()})


def register() -> Path:
    """Path of the folder of records; OSError without a home."""
    return own_folder("config") / "trusted"


def fault_of_register() -> str | None:
    """Return why the records are ignored, else None."""
    try:
        faults = ((path, fault_of(path)) for path in (register().parent, register()))
        return next((f"{path} {fault}" for path, fault in faults if fault), None)
    except OSError as error:
        return f"no folder for the list of trusted code ({error.strerror or error})"


def entry_path(folder: Path) -> Path:
    return register() / f"{digest_bytes('trust', os.fsencode(folder.resolve()))}.json"


@cache
def shipped_folders() -> set[Path]:
    """Find the folders of our own nodes, by the import paths of the running hairpipe."""
    return {folder.resolve() for folder in map(folder_of, (OUR_NODES, EXPERIMENTS)) if folder}


def code_in(folder: Path) -> dict[str, str]:
    """Digest the importable files of a folder, by relative path; BadInput if one cannot be read."""
    try:
        return {os.fspath(path.relative_to(folder)): digest_file(path) for path in sorted(sources(folder))}
    except OSError as error:
        raise BadInput(f"cannot be read: {error.strerror}", where=error.filename or folder) from None


def sources(folder: Path) -> Iterator[Path]:
    """Iterate over the importable files of a folder, without cached bytecode, which is never read."""
    seen: set[Path] = set()
    for place, within, names in os.walk(folder, followlinks=True):
        real = Path(place).resolve()
        if real in seen:  # by a link, perhaps to a folder above
            within.clear()
            continue
        seen.add(real)
        within[:] = sorted(name for name in within if not name.startswith("."))
        left_out = BYTECODE_SUFFIXES if Path(place).name == CACHED else []
        for path in (Path(place, name) for name in names):
            is_code = path.name.endswith(tuple(all_suffixes())) or not NATIVE.isdisjoint(path.suffixes)
            if is_code and path.suffix not in left_out and path.is_file():
                yield path


def differing(old: Files, new: Files) -> list[str]:
    """List the names of differing files."""
    return sorted(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
