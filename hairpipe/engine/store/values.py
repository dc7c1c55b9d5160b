"""Values in the store: named by their content, and verified when they are read. This is the workers' side.

The codec takes a value apart into a tree of arrays and scalars, digests it, writes and reads it, and builds it again.
It is imported by name: the engine knows no format. What a node is given is always a fresh copy built from such a tree,
so that a node cannot change what another one sees, and a value that was just computed is the same, byte for byte, as
one that was read.

A file with companions is a listing, which says which object has which name, and is named by its content.
"""

import copy
import errno
import importlib
import json
import os
import shutil
from collections import Counter, OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, NoReturn
from unicodedata import category

from hairpipe.engine.node.declare import File, Spent
from hairpipe.engine.store.atomic import flush, open_made, reopening, replacing
from hairpipe.engine.store.digest import digest, parsed
from hairpipe.engine.store.fingerprint import CHUNK, digest_file
from hairpipe.engine.store.lease import Leases, lease_of
from hairpipe.engine.store.store import LostObject, Output, Store, is_object
from hairpipe.errors import BadInput

CODEC = "hairpipe.formats.hdf5"
MOST_BYTES = 64 << 20
"""Of a listing: about a million companions [bytes]."""


@dataclass(frozen=True)
class Listing:
    """Objects of a file and of what must lie next to it."""

    path: str  # object of the file itself
    companions: dict[str, str]  # objects by relative name; ValueError for one that `check_name` refuses

    def __post_init__(self) -> None:
        for label in self.companions:
            check_name(label)

    @property
    def name(self) -> str:
        """Name of the object that the listing is."""
        return digest("set", self._plain) + ".set"

    @property
    def text(self) -> str:
        return json.dumps(self._plain)

    @property
    def _plain(self) -> dict[str, Any]:
        return {"path": self.path, "companions": self.companions}


def check_name(label: str) -> None:
    """Refuse the name of a companion that would lead out of the folder of its file, or that hides where it leads."""
    path = PurePosixPath(label)
    is_plain = bool(path.parts) and not path.is_absolute() and ".." not in path.parts and str(path) == label
    if not is_plain or any(category(letter) in ("Cc", "Cs") for letter in label):
        raise ValueError(f"companion {label!r} is not a relative name")


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


FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a file that does not fit: on the disk, in a quota, in the limit of a process."""
MARGIN = 16 << 20
"""Space that stays free on a disk: a file that does not fit is refused before it is begun [bytes]."""


class Values:
    """Reads and writes values of a store; the latest ones stay in memory.

    limit      of the memory that values kept for later may take, and that unwritten ones may [bytes]
    unwritten  trees by name that the store does not have: the states of scans
    """

    def __init__(self, store: Store, limit: int) -> None:
        self.store = store
        self.codec: Any = importlib.import_module(CODEC)
        self.limit = limit
        self.unwritten: dict[str, Any] = {}
        self._continued: Counter[str] = Counter()
        self._leases = Leases(store)
        self._trees: OrderedDict[str, Any] = OrderedDict()
        self._held = 0
        self._verified: set[str] = set()
        self._handed: set[str] = set()
        self._lost: str | None = None

    def lost(self) -> str | None:
        """Name an object that was requested since the last call and was missing, or has gone since; None for none.

        A node may find a file gone while it reads it, and raise an error of its own.
        """
        handed = self._handed
        self._handed = set()
        found = self._lost
        self._lost = None
        return found or next((name for name in sorted(handed) if not self.store.has(name)), None)

    def check(self) -> None:
        """Raise LostObject where one was missing since the last call of `lost`, even if the node caught the error."""
        if self._lost is not None:
            raise LostObject(self._lost)

    def get(self, name: str, kind: type) -> Any:
        """Read a value of this type; LostObject where it is not there, whole."""
        if kind is File:
            return self._get_file(name)
        if kind is Spent:
            return self._get_spent(name)
        tree = self.unwritten.get(name, self._trees.get(name))
        if tree is None:
            tree = self._read(name)
            self._keep(name, tree)
        elif name in self._trees:
            self._trees.move_to_end(name)
        return self.codec.build(kind, copy.deepcopy(tree))

    def _get_spent(self, key: str) -> Spent:
        record = self.store.record(key)
        if record is None:
            raise BadInput(f"the record of the result {key} is missing", where=self.store.root, right="run again")
        return Spent(record.seconds, record.seconds if record.processor is None else record.processor)

    def put(self, value: Any, kind: type, workspace: Path | None, *, lasting: bool = True) -> Output:
        """Write a value under the name of its content; TypeError where it is not of the declared type.

        lasting  False: the value stays in memory, unwritten, unless the store or another process has it
        """
        if not isinstance(value, kind):
            raise TypeError(f"returned a {type(value).__name__}, declared {kind.__name__}")
        if isinstance(value, File):
            return self._put_file(value, workspace)
        tree = self.codec.take_apart(value)
        name = self.codec.digest_tree(tree) + ".h5"
        own = copy.deepcopy(tree)  # the node's arrays may be views of larger ones, or still its own
        if lasting or self.store.has(name) or not self._reserve(name):
            return self._write_tree(name, own)
        self.unwritten[name] = own
        while len(self.unwritten) > 1 and sum(map(self.codec.nbytes, self.unwritten.values())) > self.limit:
            oldest = next(iter(self.unwritten))
            self._write_tree(oldest, self.unwritten[oldest])
        return Output(name, self.codec.file_size(own))

    def _reserve(self, name: str) -> bool:
        """Whether this process may be the only one that has a value; another one would forget it without asking."""
        if name not in self.unwritten and not self._leases.acquire(lease_of(name)):
            return False
        self._continued[name] += 1
        return True

    def write_out(self) -> None:
        for name, tree in list(self.unwritten.items()):
            self._write_tree(name, tree)

    def forget(self, name: str) -> None:
        """Forget a value that is not written, unless it was put more often: scans can have equal states."""
        self._continued[name] -= 1
        if self._continued[name] <= 0:
            self._drop(name)

    def _drop(self, name: str) -> None:
        self.unwritten.pop(name, None)
        self._continued.pop(name, None)
        self._leases.release(lease_of(name))

    def _write_tree(self, name: str, tree: Any) -> Output:
        size = self._write(name, self.codec.nbytes(tree), lambda path: self.codec.write(tree, path))
        self._drop(name)
        self._keep(name, tree)
        return Output(name, size)

    def _read(self, name: str) -> Any:
        """Read a tree and check its digest; a file that cannot be read for lack of permission is kept."""
        with suppress(FileNotFoundError, BadInput):
            if self.store.has(name):
                tree = reopening(self.codec.read)(self.store.object_path(name))
                if self.codec.digest_tree(tree) + ".h5" == name:
                    return tree
        self._lose(name)

    def _keep(self, name: str, tree: Any) -> None:
        self._held += self.codec.nbytes(tree) - (self.codec.nbytes(self._trees[name]) if name in self._trees else 0)
        self._trees[name] = tree
        self._trees.move_to_end(name)
        while self._held > self.limit and self._trees:
            self._held -= self.codec.nbytes(self._trees.popitem(last=False)[1])

    def _lose(self, name: str) -> NoReturn:
        self._lost = name
        self.store.remove(self.store.object_path(name))
        raise LostObject(name)

    def _get_file(self, name: str) -> File:
        """Check the bytes of a file, and of its companions."""
        if name.endswith(".bin"):
            return File(self._checked(name))
        try:
            listing = read_listing(self.store, name)
        except LostObject:
            self._lose(name)
        parts = {label: self._checked(part) for label, part in listing.companions.items()}
        return File(self._checked(listing.path), parts)

    def _checked(self, name: str) -> Path:
        path = self.store.object_path(name)
        if self.store.has(name):
            with suppress(FileNotFoundError):
                if name in self._verified or digest_file(path) + ".bin" == name:
                    self._verified.add(name)
                    self._handed.add(name)
                    return path
        self._lose(name)

    def _put_file(self, file: File, workspace: Path | None) -> Output:
        """Store the bytes of a file; with companions, a list of files by name is the object."""
        main = self._put_bytes(file.path, workspace)
        if not file.companions:
            return main
        parts = {label: self._put_bytes(path, workspace) for label, path in file.companions.items()}
        listing = Listing(main.object, {label: part.object for label, part in parts.items()})
        size = self._write(listing.name, len(listing.text), lambda to: to.write_bytes(listing.text.encode()))
        return Output(listing.name, size, tuple((part.object, part.size) for part in (main, *parts.values())))

    def _put_bytes(self, path: Path, workspace: Path | None) -> Output:
        """Store the bytes of a file; one of the workspace is not copied, where the file system has hard links."""
        path = path.resolve()
        name = digest_file(path) + ".bin"
        size = reopening(path.stat)().st_size
        if workspace is not None and path.is_relative_to(workspace.resolve()) and not self.store.has(name):
            path.chmod(0o444)
            flush(path)
            with suppress(OSError):
                os.link(path, self.store.room(self.store.object_path(name)))
                return Output(name, size)
        return Output(name, self._write(name, size, lambda to: copy_file(path, to)))

    @reopening
    def _write(self, name: str, expected: int, write: Callable[[Path], object]) -> int:
        """Write an object unless it is there; returns its size [bytes]."""
        size = self.store.size(name)
        if size is None:
            check_space(self.store.root, expected)
            with replacing(self.store.room(self.store.object_path(name)), self.store.temporary) as temporary:
                write(temporary)
                temporary.chmod(0o444)
                size = temporary.stat().st_size
        else:
            self.store.renew(name)
        return size


def copy_file(source: Path, target: Path) -> None:
    with source.open("rb") as reader, open_made(target) as writer:
        shutil.copyfileobj(reader, writer, CHUNK)


def check_space(root: Path, needed: int) -> None:
    """Raise the error of a full disk before a file is begun that does not fit."""
    root.mkdir(parents=True, exist_ok=True)
    if shutil.disk_usage(root).free < needed + MARGIN:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(root))


def is_full(error: OSError) -> bool:
    """Whether an error means that a disk is full; HDF5 reports it in its message only."""
    return error.errno in FULL or any(f"errno = {number}" in str(error) for number in FULL)
