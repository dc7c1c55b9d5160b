"""Values on disk: any frozen dataclass of arrays and scalars as an HDF5 file, and its digest.

A value is converted into a tree: None, bool, int, float, str, tuple of str, numpy array, or a dict of such by name.
Dataclasses and NamedTuples become dicts of their fields. The tree of a value in memory equals that of its file, down to
the order of names. The file contains names and data, never a class or code; the reader states the type to build.
Equal trees give equal digests and, with one h5py, equal bytes.

A dict is a group, an array a contiguous dataset, a text or a tuple of texts a dataset of fixed-length UTF-8; None and
numbers are attributes of their group. The format is that of HDF5 1.10, which guards its own structure by checksums, so
that a damaged file is refused rather than misread; the data is guarded by the digest.
"""

import dataclasses
import errno
import os
import re
import resource
import tempfile
import types
from collections.abc import Iterator
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from hairpipe.errors import BadInput
from hairpipe.plain_file import special_kind

T = TypeVar("T")
Tree = Any
"""None, bool, int, float, str, tuple of str, C-ordered little-endian array, or dict of trees, sorted by name."""

DIGEST_BYTES = 20
FORMAT = ("v110", "v110")
BLOCK = 1 << 16
OVERHEAD = 4096
"""Approximate overhead of HDF5: once, and for each entry [bytes]."""
NUMBERS = "biuf"
"""Kinds of numpy arrays that are stored: bool, integers with and without sign, floats."""
ESCAPES = {"%": "%25", "/": "%2F", ".": "%2E"}
"""HDF5 reads / and . in a name as a path."""
REFUSED = re.compile(r"errno = ([1-9]\d*)")
"""The system's error number in the text of an HDF5 error of any type."""


def encode(value: Any, path: Path) -> None:
    """Write a value as an HDF5 file; TypeError or ValueError names a field that cannot be stored."""
    write(take_apart(value), path)


def decode(path: Path, kind: type[T]) -> T:
    """Read a value of this type; BadInput where the file is damaged or contains another type."""
    tree = read(path)
    try:
        return build(kind, tree)
    except TypeError as error:
        raise BadInput(f"not a {kind.__name__}: {error}", where=path) from None


def digest(value: Any) -> str:
    """Digest a value by the names, types, shapes and bytes of its fields."""
    return digest_tree(take_apart(value))


def take_apart(value: Any, name: str = "value") -> Tree:
    """Convert a value into a tree; arrays are copied only if they are not C-ordered and little-endian."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return take_apart({field.name: getattr(value, field.name) for field in dataclasses.fields(value)}, name)
    if isinstance(value, tuple) and (names := getattr(value, "_fields", None)) is not None:
        return take_apart(dict(zip(names, value, strict=True)), name)
    if isinstance(value, dict):
        items = {checked_text(key, name): take_apart(item, f"{name}.{key}") for key, item in value.items()}
        return dict(sorted(items.items()))
    if isinstance(value, np.ndarray):
        return plain_array(value, name)
    if isinstance(value, tuple):
        return tuple(checked_text(item, name) for item in value)
    return plain_scalar(value, name)


def plain_array(array: np.ndarray, name: str) -> np.ndarray:
    """Lay an array out in C order and little-endian."""
    if array.dtype.kind not in NUMBERS or array.dtype.itemsize > 8:
        raise TypeError(f"{name}: arrays of {array.dtype} are not stored; bool, integers and floats up to 64 bits are")
    return np.asarray(array, dtype=array.dtype.newbyteorder("<"), order="C")


def plain_scalar(value: Any, name: str) -> Tree:
    """Turn numpy's scalars into Python's; TypeError for other values."""
    value = value.item() if isinstance(value, np.generic) else value
    if value is None or type(value) in (bool, float):
        return value
    if type(value) is int:
        if not -(2**63) <= value < 2**63:
            raise ValueError(f"{name} = {value} has more than 64 bits")
        return value
    if isinstance(value, str):
        return checked_text(value, name)
    raise TypeError(
        f"{name}: a {type(value).__name__} is not stored; arrays, numbers, texts and dataclasses of them are"
    )


def checked_text(value: Any, name: str) -> str:
    """Return a plain text; raise for other values, and for a text that HDF5 does not preserve."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: a {type(value).__name__} where only a text is stored")
    if "\0" in value:
        raise ValueError(f"{name}: {value!r} has a NUL in it")
    return str.__str__(value)  # a subclass may have another __str__, and so another digest


def digest_tree(tree: Tree) -> str:
    state = blake2b(digest_size=DIGEST_BYTES, person=b"value")
    for path, leaf in leaves(tree, ()):
        array = leaf if isinstance(leaf, np.ndarray) else None
        head = (array.dtype.str, array.shape) if array is not None else (type(leaf).__name__, leaf)
        state.update(repr((path, *head)).encode())
        if array is not None and array.size:
            state.update(array.data)
    return state.hexdigest()


def leaves(tree: Tree, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Tree]]:
    """Walk a tree in order; a dict comes before its items, as the tuple of its names.

    An empty tuple of texts comes as a list, to distinguish it from an empty dict.
    """
    if isinstance(tree, dict):
        yield path, tuple(tree)
        for name, item in tree.items():
            yield from leaves(item, (*path, name))
    else:
        yield path, [] if isinstance(tree, tuple) and not tree else tree


def nbytes(tree: Tree) -> int:
    return sum(leaf.nbytes for _, leaf in leaves(tree, ()) if isinstance(leaf, np.ndarray))


def file_size(tree: Tree) -> int:
    """Return the size of the file that `write` makes of a tree [bytes], from a file without the data of its arrays."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "hollow")
        write(tree, path, hollow=True)
        return path.stat().st_size


def write(tree: Tree, path: Path, *, hollow: bool = False) -> None:
    """Write a tree to a new file; OSError beforehand where this process may not write as large a file.

    HDF5 does not survive a file that reaches the limit (`ulimit -f`) while it is written.

    hollow  the file is sparse: room for each array, with one element of it
    """
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    texts = (repr(leaf) for _, leaf in leaves(tree, ()) if not isinstance(leaf, np.ndarray))
    if limit != resource.RLIM_INFINITY and limit < nbytes(tree) + BLOCK + sum(OVERHEAD + 8 * len(t) for t in texts):
        raise OSError(errno.EFBIG, os.strerror(errno.EFBIG), str(path))
    with h5py.File(path, "w", libver=FORMAT, locking=False) as file:
        write_entry(file, "value", tree, hollow=hollow)


def write_entry(group: h5py.Group, name: str, tree: Tree, *, hollow: bool = False) -> None:
    if isinstance(tree, dict):
        inner = group.create_group(escape(name))
        for key, item in tree.items():
            write_entry(inner, key, item, hollow=hollow)
    elif isinstance(tree, np.ndarray) and tree.size and hollow:
        dataset = group.create_dataset(escape(name), tree.shape, tree.dtype, track_times=False)
        dataset[(0,) * tree.ndim] = 0  # HDF5 allocates an array when its first element is written
    elif isinstance(tree, np.ndarray):
        group.create_dataset(escape(name), data=tree, track_times=False)
    elif isinstance(tree, str | tuple):
        texts = [text.encode() for text in ([tree] if isinstance(tree, str) else tree)]
        kind = h5py.string_dtype("utf-8", max([1, *map(len, texts)]))
        data = np.array(texts, dtype=kind)
        group.create_dataset(escape(name), data=data[0] if isinstance(tree, str) else data, dtype=kind)
    else:
        group.attrs[escape(name)] = h5py.Empty("f8") if tree is None else tree


def read(path: Path) -> Tree:
    """Read a tree; BadInput where the file is not an HDF5 value, OSError where the system does not let it be read.

    Only the digest detects changed data.
    """
    found = path.stat()
    if kind := special_kind(found):
        raise BadInput(f"not a complete HDF5 value: {kind}", where=path)
    try:
        with h5py.File(path, "r", locking=False) as file:
            return Reader(found.st_size).group(file)["value"]
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, OverflowError) as error:
        refused = REFUSED.search(str(error))
        if refused:
            raise OSError(int(refused[1]), os.strerror(int(refused[1])), str(path)) from None
        raise BadInput(f"not a complete HDF5 value: {error}", where=path) from None


def digest_file(path: Path) -> str:
    """Digest the value in a file, as `digest`; BadInput for another file."""
    return digest_tree(read(path))


class Reader:
    """Reader of files of `write`; other contents of HDF5 are refused: external links, data outside the file.

    room  bytes left for arrays: these are not compressed, so that their total is at most the size of the file
    seen  addresses of objects that were read, against loops
    """

    def __init__(self, size: int) -> None:
        self.room = size
        self.seen = set[int]()

    def group(self, group: h5py.Group) -> dict[str, Tree]:
        self.visit(group)
        tree: dict[str, Tree] = {}
        for name, value in group.attrs.items():
            tree[unescape(str(name))] = None if isinstance(value, h5py.Empty) else plain_scalar(value, name)
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise ValueError(f"{name} is a link to elsewhere")
            item = group[name]
            if isinstance(item, h5py.Group):
                tree[unescape(str(name))] = self.group(item)
            elif isinstance(item, h5py.Dataset):
                tree[unescape(str(name))] = self.dataset(item)
            else:
                raise ValueError(f"{name} is neither a group nor an array")
        return dict(sorted(tree.items()))

    def dataset(self, dataset: h5py.Dataset) -> Tree:
        """Read an array or texts; ValueError where the data is not in the file, or larger than the file."""
        self.visit(dataset)
        if not 0 <= dataset.nbytes <= self.room:
            raise ValueError(f"{dataset.name} is larger than its file")
        self.room -= dataset.nbytes
        layout = dataset.id.get_create_plist()
        if layout.get_layout() != h5py.h5d.CONTIGUOUS or layout.get_external_count() or dataset.dtype.hasobject:
            raise ValueError(f"the data of {dataset.name} does not lie in the file as one piece")
        if dataset.dtype.kind == "S":
            texts = dataset.asstr()[()]
            return tuple(texts.tolist()) if isinstance(texts, np.ndarray) else texts
        array = np.empty(dataset.shape, dataset.dtype)
        if array.size:
            dataset.read_direct(array)
        return plain_array(array, str(dataset.name))

    def visit(self, item: h5py.Group | h5py.Dataset) -> None:
        """Note an object as read; ValueError for the second time."""
        address = h5py.h5o.get_info(item.id).addr  # pyright: ignore[reportAttributeAccessIssue] - its stubs lack it
        if address in self.seen:
            raise ValueError(f"{item.name} has two names")
        self.seen.add(address)


def escape(name: str) -> str:
    """Escape a name that HDF5 would read as a path."""
    return "".join(ESCAPES.get(letter, letter) for letter in name) or "%"


def unescape(name: str) -> str:
    if name == "%":
        return ""
    for letter, spelled in reversed(ESCAPES.items()):
        name = name.replace(spelled, letter)
    return name


def build(kind: Any, tree: Tree) -> Any:
    """Build a value of this type from a tree, sharing its arrays; TypeError where the tree does not fit."""
    if get_origin(kind) in (Union, types.UnionType):
        inner = [option for option in get_args(kind) if option is not type(None)]
        return None if tree is None and len(inner) < len(get_args(kind)) else build(inner[0], tree)
    if hasattr(kind, "__annotations__") and (dataclasses.is_dataclass(kind) or issubclass(kind, tuple)):
        hints = field_types(kind)
        if not isinstance(tree, dict) or tree.keys() != hints.keys():
            found = ", ".join(tree) if isinstance(tree, dict) else type(tree).__name__
            raise TypeError(f"{kind.__name__} has the fields {', '.join(hints)}, found {found}")
        record: Any = kind
        return record(**{name: build(hint, tree[name]) for name, hint in hints.items()})
    if get_origin(kind) is dict and isinstance(tree, dict):
        return {name: build(get_args(kind)[1], item) for name, item in tree.items()}
    if not isinstance(tree, get_origin(kind) or kind):
        raise TypeError(f"wanted {kind}, found {type(tree).__name__}")
    return tree


@cache
def field_types(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind)
    names = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else kind._fields
    return {name: hints[name] for name in names}
