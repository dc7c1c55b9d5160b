"""Publishes files: copies them from the store to the paths in the graph file, atomically, where they differ.

Record of published files: it distinguishes files that hairpipe may replace from those of the user.

It lies in a folder of the user, since the store may be deleted or exchanged. A line is added for each written file;
the last line of a name is valid, and a damaged line is ignored.
"""

import json
import os
import stat
from contextlib import suppress
from pathlib import Path

from hairpipe.engine.file.bounds import Bounds, check_way, entered
from hairpipe.engine.file.graph import Graph
from hairpipe.engine.node.declare import DATA_SUFFIXES
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.store.atomic import keep_mode, open_made, reopening, replacing, sweep
from hairpipe.engine.store.digest import digest_bytes, hasher, parsed
from hairpipe.engine.store.fingerprint import CHUNK, fingerprint
from hairpipe.engine.store.ownership import fault_of, make_own, own_folder
from hairpipe.engine.store.store import LostObject, Output, Store
from hairpipe.engine.store.values import read_listing
from hairpipe.errors import BadInput

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


class Publisher:
    """Publishes the files of one run; no task overwrites the files of another one, or of the graph.

    root   below which files may be published, in addition to the graph's project, or None
    force  whether a file is replaced that hairpipe has not published

    Raises BadInput for a graph that would publish outside of both.
    """

    def __init__(self, store: Store, graph: Graph, root: Path | None = None, *, force: bool = False) -> None:
        self.store, self.force = store, force
        self.bounds = Bounds(graph, store.root, root)
        self.bounds.check()
        self.ledger = Ledger()
        self.placed: dict[Path, tuple[Task, str]] = {}
        self.swept: set[Path] = set()

    def publish(self, task: Task, output: Output, path: Path) -> bool:
        """Copy a file and its companions to a path; returns whether anything had to be written.

        Raises BadInput, and writes nothing, where another task has published other bytes, where the user's own file
        lies, or where nothing may be published; LostObject where the store no longer has it whole; OSError where it
        cannot be written there.
        """
        files = files_of(self.store, output, path)
        roots = {place: self._check(task, name, place) for place, name in files.items()}
        self.placed |= {place: (task, name) for place, name in files.items()}
        return any([self._copy(name, place, roots[place]) for place, name in files.items()])

    def is_kept(self, path: Path) -> bool:
        """Whether a file lies at a path that must not be replaced, unless the new one equals it."""
        try:
            return not self.force and not self._is_ours(path)
        except (OSError, BadInput):  # reported when it is published
            return False

    def _check(self, task: Task, name: str, place: Path) -> Path:
        """Refuse a place that this task must not write to; returns the folder below which it may publish."""
        root = self.bounds.folder_of(place)
        check_way(place)
        writes = {*DATA_SUFFIXES, *self.bounds.graph.nodes[task.node].type.writes}
        if place.suffix.lower() not in writes:  # that of a companion is known only now
            raise BadInput(f"'{place.suffix}' is not a suffix of data", where=place, right=", ".join(sorted(writes)))
        other, there = self.placed.get(place, (task, name))
        if other != task and there != name:
            what = f"'{other}' has published another file at this path"
            raise BadInput(what, where=place, right="a folder of its own to publish in")
        if not self._is_ours(place, name) and not self.force:
            what = "a file exists that is not from hairpipe, or was changed since"
            raise BadInput(what, where=place, right="another path, or --force to overwrite it")
        return root

    def _is_ours(self, place: Path, name: str = "") -> bool:
        """Whether an object may be written to a place: the file there was published by us, or is in the store."""
        found = digest_there(place, self.store)
        if found is None or f"{found}.bin" == name or found == self.ledger.digest(place):
            return True
        return self.store.has(f"{found}.bin")

    def _copy(self, name: str, place: Path, root: Path) -> bool:
        """Copy the bytes of an object to a place unless they are there."""
        written = f"{digest_there(place, self.store)}.bin" != name
        if written:
            try:
                with entered(root, place.parent) as folder:
                    if place.parent not in self.swept:
                        self.swept.add(place.parent)
                        sweep(folder)
                    copy_object(self.store, name, folder / place.name)
            except OSError as error:  # it names the open folder
                raise OSError(error.errno, error.strerror, str(place)) from None
        self.ledger.note(place, name.removesuffix(".bin"))
        return written


def files_of(store: Store, output: Output, path: Path) -> dict[Path, str]:
    """Name the objects of a file that is published to a path, by where each goes; those next to the file come first."""
    if not output.object.endswith(".set"):
        return {path: output.object}
    listing = read_listing(store, output.object)
    return {path.parent / name: part for name, part in listing.companions.items()} | {path: listing.path}


def digest_there(place: Path, store: Store) -> str | None:
    """Digest of the file at a place; None where nothing is, BadInput where no file is."""
    try:
        mode = place.lstat().st_mode
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(mode):
        raise BadInput("the existing path is not a file", where=place, right="another path")
    return fingerprint(place, store)


@reopening
def copy_object(store: Store, name: str, path: Path) -> None:
    """Copy the bytes of an object to a path; LostObject where they do not match its name.

    They are written to a new temporary file, which is renamed when it is on disk.
    """
    state = hasher("file")
    source = store.object_path(name)
    try:
        reader = source.open("rb")
    except (FileNotFoundError, IsADirectoryError):
        store.remove(source)
        raise LostObject(name) from None
    with reader, replacing(path) as temporary:
        with open_made(temporary) as writer:
            while chunk := reader.read(CHUNK):
                state.update(chunk)
                writer.write(chunk)
        if state.hexdigest() + ".bin" != name:
            store.remove(source)
            raise LostObject(name)
        keep_mode(temporary, path)
