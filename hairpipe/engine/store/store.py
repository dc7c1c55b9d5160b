"""The store: records of actions by key, objects by content. It knows no types and verifies what it reads.

    actions/ab/<key>.json       what was evaluated and which objects came of it
    objects/ab/<name>           a value (.h5), the bytes of a file (.bin), or a file with companions (.set)
    latest/<graph>/<node>.json  key of each frame's latest result, by which `plan` explains differences
    notes/ab/<name>             cached analyses: source files, digests of input files
    tmp/                        files and workspaces in the making
    lease/<key>                 a key that is being evaluated, see `lease`

Files are written atomically; any number of processes and users may share a store, and a killed process leaves nothing
to repair. A store is data: nothing in it is executed, and compiled kernels are kept elsewhere (`machine_code`).
"""

import errno
import json
import os
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hairpipe.engine.store.atomic import discard, is_stale, now_in, reopening, sweep, write_text
from hairpipe.engine.store.digest import DIGEST, Parts, digest, digest_bytes, is_key, parsed
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from pydantic import TypeAdapter


MARK = ',"check":"'
SUFFIXES = (".h5", ".bin", ".set")
"""Of objects: a value, the bytes of a file, a file with companions."""


class Output(NamedTuple):
    """An object by name and size [bytes], and the objects it refers to: a file with companions is a list of files."""

    object: str
    size: int
    parts: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, repr=False)
class Record:
    """One evaluation, as the store remembers it.

    outputs    by name; the output named `state` of a scan may have been thinned away
    seconds    that the evaluation took [s]
    created    when, in seconds since 1970 [s]
    processor  seconds of all its threads and children, which a busy machine changes less [s]; None in older records
    prepare_warnings  of the function that prepared the node: the same at every frame
    compiled  of these seconds, how many numba compiled kernels [s]; None in older records
    processor_class  of the processor that evaluated it; None in older records
    threading_layer  of numba in that process; None where nothing was computed in parallel, and in older records
    """

    key: str
    node: str
    frame: int | None
    parts: Parts
    outputs: dict[str, Output]
    state: str | None
    seconds: float
    warnings: tuple[str, ...]
    created: float
    processor: float | None = None
    prepare_warnings: tuple[str, ...] = ()
    processor_class: str | None = None
    threading_layer: str | None = None
    compiled: float | None = None

    def __repr__(self) -> str:
        """Write node, frame, type, seconds and size."""
        frame = "" if self.frame is None else f"@{self.frame}"
        return f"<Record {self.node}{frame}: {self.parts['type']}, {self.seconds:.3g} s, {self.size:,} bytes>"

    @property
    def size(self) -> int:
        """Bytes of all objects."""
        return sum(o.size + sum(size for _, size in o.parts) for o in self.outputs.values())

    def objects(self, without: str | None = None) -> list[tuple[str, int]]:
        """List names and sizes of all objects but those of the output `without`."""
        kept = [output for name, output in self.outputs.items() if name != without]
        return [pair for output in kept for pair in ((output.object, output.size), *output.parts)]


def write_record(record: Record) -> str:
    """Write a record as JSON that carries its own check."""
    text = json.dumps(asdict(record), separators=(",", ":"))
    return f'{text[:-1]}{MARK}{digest_bytes("record", text.encode())}"}}'


@cache
def records() -> "TypeAdapter[Record]":
    """Return the reader of records, which ignores fields of other versions."""
    from pydantic import ConfigDict, TypeAdapter, with_config

    return TypeAdapter(with_config(ConfigDict(allow_inf_nan=False))(Record))


def read_record(text: str) -> Record | None:
    """Read a record; None where it is damaged, or no record of hairpipe."""
    body, mark, check = text.rpartition(MARK)
    if not mark or check != digest_bytes("record", f"{body}}}".encode()) + '"}':
        return None
    try:
        record = records().validate_json(body + "}", strict=True)
    except ValueError:
        return None
    parts = record.parts
    is_sound = (
        is_key(record.key)
        and parts.keys() == {"type", "code", "settings", "inputs", "time"}
        and all(isinstance(parts[name], str) for name in ("type", "code"))
        and all(isinstance(parts[name], dict) for name in ("settings", "inputs"))
        and isinstance(parts["time"], dict | None)
        and all(is_object(name) and size >= 0 for name, size in record.objects())
        and (record.state is None or record.state in record.outputs)
    )
    return record if is_sound else None


def is_object(name: Any, *suffixes: str) -> bool:
    """Whether something is the name of an object, of these kinds or of any: it becomes a path."""
    if not isinstance(name, str):
        return False
    stem, dot, suffix = name.partition(".")
    return DIGEST.fullmatch(stem) is not None and dot + suffix in (suffixes or SUFFIXES)


class LostObject(Exception):
    """An object that is needed is missing or was damaged, and has been removed."""

    def __init__(self, name: str) -> None:
        super().__init__(f"object {name} is missing or damaged")
        self.name = name


class Store:
    """A folder of results; it is made when something is written.

    read_only  writes and removes nothing, as a plan promises
    """

    def __init__(self, root: Path, *, read_only: bool = False) -> None:
        self.root = root.absolute()
        self.read_only = read_only
        self.temporary = self.root / "tmp"

    def sweep(self) -> int:
        """Remove what killed processes left behind; returns how many files and folders."""
        if self.read_only:
            return 0
        swept = sweep(self.temporary)
        for path in (self.root / "lease").glob("[0-9a-f]*"):
            with suppress(OSError):
                if is_stale(path):
                    discard(path)
                    swept += 1
        return swept

    def now(self) -> float:
        """Read the clock by which the files of the store are stamped, in s since 1970; that of a machine may differ."""
        with suppress(OSError):
            if not self.read_only and self.root.is_dir():
                return now_in(self.room(self.temporary / "any").parent)
        return time.time()

    def check_writable(self, needed: str) -> None:
        """Refuse a store that cannot be written to, before anything is computed; reading it is allowed.

        needed  name of what has to be computed
        """
        if self.root.exists() and not os.access(self.root, os.W_OK | os.X_OK):
            what = f"{needed} has to be computed, and the store cannot be written to"
            raise BadInput(what, where=self.root, right="--cache FOLDER of your own, or permission to write")

    def action_path(self, key: str) -> Path:
        """Where the record of a key lies; ValueError for an invalid key."""
        if not is_key(key):
            raise ValueError(f"{key!r} is not a key")
        return self.root / "actions" / key[:2] / f"{key}.json"

    def object_path(self, name: str) -> Path:
        """Where an object lies; ValueError for an invalid name."""
        if not is_object(name):
            raise ValueError(f"{name!r} is not an object")
        return self.root / "objects" / name[:2] / name

    def record_keys(self) -> Iterator[str]:
        """Iterate over the keys of all record files, intact or damaged."""
        for path in (self.root / "actions").glob("??/*.json"):
            if is_key(path.stem) and self.action_path(path.stem) == path:
                yield path.stem

    def object_names(self) -> Iterator[str]:
        """Iterate over the names of all object files, intact or damaged."""
        for path in (self.root / "objects").glob("??/*"):
            if is_object(path.name) and self.object_path(path.name) == path:
                yield path.name

    def find(self, key: str, *, without: str | None = None) -> Record | None:
        """Find a record whose objects are all there, except those of the output `without`; None for a damaged one."""
        record = self.record(key)
        if record and all(self.has(name, size) for name, size in record.objects(without)):
            return record
        return None

    def record(self, key: str) -> Record | None:
        """Read the record of a key, whether its objects are there or not; a damaged record is removed."""
        path = self.action_path(key)
        text = self._text(path)
        if text is None:
            return None
        record = read_record(text)
        if record is None or record.key != key:
            self.remove(path)
            return None
        return record

    def has(self, name: str, size: int | None = None) -> bool:
        """Whether an object is there with the right size; its bytes are checked when it is read."""
        found = self.size(name)
        if found is None or size is None or found == size:
            return found is not None
        self.remove(self.object_path(name))
        return False

    def size(self, name: str) -> int | None:
        """Size of an object [bytes]; None where it is missing. Anything but a file in its place is removed."""
        path = self.object_path(name)
        try:
            status = reopening(path.stat)()
        except OSError:
            return None
        if stat.S_ISREG(status.st_mode):
            return status.st_size
        self.remove(path)
        return None

    def add(self, record: Record) -> None:
        """Keep a record; its objects are in the store already."""
        write_text(self.room(self.action_path(record.key)), write_record(record), self.temporary)

    def refresh(self, key: str) -> None:
        """Open the folder of a record: a client of a network file system then forgets that a record was missing."""
        with suppress(OSError):
            os.close(os.open(self.action_path(key).parent, os.O_RDONLY))

    def touch(self, key: str) -> None:
        """Mark a result as used now: cleaning goes by age."""
        with suppress(OSError):
            os.utime(self.action_path(key))

    def renew(self, name: str) -> None:
        """Mark an object as new: it is about to be referenced by a record, and cleaning spares new objects."""
        with suppress(OSError):
            os.utime(self.object_path(name))

    def remove(self, path: Path) -> None:
        """Remove a file of the store, or a folder that stands in its place."""
        if not self.read_only:
            with suppress(OSError):
                discard(path)

    @reopening
    def room(self, path: Path) -> Path:
        """Create the folders of a file, and remove whatever blocks them or its place; returns its path."""
        if path.is_dir():
            self.remove(path)
        for folder in (path.parent, self.temporary):
            try:
                self._make(folder)
            except (FileExistsError, NotADirectoryError):
                for blocked in reversed([folder, *folder.parents]):
                    if blocked.is_relative_to(self.root) and blocked != self.root and not blocked.is_dir():
                        self.remove(blocked)
                self._make(folder)
        return path

    def _make(self, folder: Path) -> None:
        """Create a folder of the store; of the group of the store, and writable for it, where the store is."""
        if folder == self.root:
            folder.mkdir(parents=True, exist_ok=True)
        elif not folder.is_dir():
            self._make(folder.parent)
            folder.mkdir(exist_ok=True)
            root = self.root.stat()
            if root.st_mode & stat.S_IWGRP:
                with suppress(OSError):  # another process may have made it
                    os.chown(folder, -1, root.st_gid)
                    folder.chmod(stat.S_IMODE(root.st_mode) | stat.S_ISGID)

    @reopening
    def _text(self, path: Path) -> str | None:
        """Read a text; None where there is no file, empty where there is something else."""
        try:
            return path.read_text(encoding="utf-8") if stat.S_ISREG(path.stat().st_mode) else ""
        except UnicodeDecodeError:
            return ""
        except OSError as error:
            if error.errno not in (errno.ENOENT, errno.ENOTDIR, errno.ELOOP):
                raise
        return "" if path.is_symlink() else None  # a file may be there by now, which is not to be taken for damaged

    def recall(self, name: str) -> str | None:
        """Return the text noted under a name; None where it is missing or damaged."""
        try:
            note = parsed(self._text(self.root / "notes" / name[:2] / name) or "null")
            is_whole = isinstance(note["note"], str) and note["digest"] == digest("note", [name, note["note"]])
            return note["note"] if is_whole else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def remember(self, name: str, make: Callable[[], str]) -> str:
        """Return the text noted under a name, or make and note it."""
        known = self.recall(name)
        if known is None:
            known = make()
            self.note(name, known)
        return known

    def note(self, name: str, text: str) -> None:
        if not self.read_only:
            path = self.root / "notes" / name[:2] / name
            whole = {"note": text, "digest": digest("note", [name, text])}
            with suppress(OSError):  # a note only saves time, and a damaged one is ignored
                write_text(self.room(path), json.dumps(whole), self.temporary, lasting=False)

    def forget(self, name: str) -> None:
        with suppress(OSError):
            (self.root / "notes" / name[:2] / name).unlink(missing_ok=True)

    def latest(self, graph: str, node: str) -> dict[str, str]:
        """Keys of the latest results of a node, by frame as text ("" for the shot)."""
        try:
            keys = parsed(self._text(self._latest_path(graph, node)) or "null")
        except (OSError, ValueError):
            return {}
        return {frame: key for frame, key in keys.items() if is_key(key)} if isinstance(keys, dict) else {}

    def set_latest(self, graph: str, node: str, keys: dict[str, str]) -> None:
        """Note the latest results of a node; frames that are not given stay as they were."""
        known = self.latest(graph, node)
        if any(known.get(frame) != key for frame, key in keys.items()):
            write_text(self.room(self._latest_path(graph, node)), json.dumps(known | keys), self.temporary)

    def _latest_path(self, graph: str, node: str) -> Path:
        return self.root / "latest" / graph / f"{node}.json"
