"""Copies files from the store to where the graph file says: whole or not at all, and only what is not there already."""

import errno
import json
import os
from pathlib import Path

from hairpipe.graph.atomic import replacing
from hairpipe.graph.canonical import hasher
from hairpipe.graph.fingerprint import CHUNK, fingerprint
from hairpipe.graph.record import Output
from hairpipe.graph.store import LostObject, Store


def publish(store: Store, output: Output, path: Path) -> bool:
    """Copy a file, and those beside it, to a path; returns whether anything had to be written.

    Raises LostObject where the store no longer has it whole, OSError where it cannot be written there.
    """
    if not output.parts:
        return copy_object(store, output.object, path)
    try:
        listing = json.loads(store.object_path(output.object).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        store.remove(store.object_path(output.object))
        raise LostObject(output.object) from None
    beside = [copy_object(store, part, path.parent / name) for name, part in listing["companions"].items()]
    return any([*beside, copy_object(store, listing["path"], path)])


def copy_object(store: Store, name: str, path: Path) -> bool:
    """Copy the bytes of an object to a path unless they are there."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.is_file() and fingerprint(path, store) + ".bin" == name:
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    state = hasher("file")
    source = store.object_path(name)
    if not source.is_file():
        raise LostObject(name)
    with replacing(path) as temporary:
        with source.open("rb") as reader, temporary.open("wb") as writer:
            while chunk := reader.read(CHUNK):
                state.update(chunk)
                writer.write(chunk)
        if state.hexdigest() + ".bin" != name:
            store.remove(source)
            raise LostObject(name)
    return True
