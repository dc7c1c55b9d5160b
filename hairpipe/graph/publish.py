"""Copies files from the store to where the graph file says: whole or not at all, and only what is not there already."""

import errno
import os
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graph.atomic import open_made, replacing
from hairpipe.graph.canonical import hasher
from hairpipe.graph.fingerprint import CHUNK, fingerprint
from hairpipe.graph.graph import Graph
from hairpipe.graph.listing import read_listing
from hairpipe.graph.record import Output
from hairpipe.graph.store import LostObject, Store
from hairpipe.graph.tasks import Task


class Publisher:
    """Publishes the files of one run, and remembers whose lie where: nobody overwrites another's, nor the graph's."""

    def __init__(self, store: Store, graph: Graph) -> None:
        self.store, self.graph = store, graph
        self.placed: dict[Path, tuple[Task, str]] = {}

    def publish(self, task: Task, output: Output, path: Path) -> bool:
        """Copy a file, and those beside it, to a path; returns whether anything had to be written.

        Raises BadInput, and writes nothing, where another task has published other bytes or the graph is made of what
        is there; LostObject where the store no longer has it whole; OSError where it cannot be written there.
        """
        files = files_of(self.store, output, path)
        for place, name in files.items():
            role = self.graph.role(place.resolve())
            if role is not None:
                raise BadInput(f"it is {role}", where=place, right="a folder of its own to publish in")
            other, there = self.placed.get(place, (task, name))
            if other != task and there != name:
                what = f"'{other}' has published another file there"
                raise BadInput(what, where=place, right="a folder of its own to publish in")
        self.placed |= {place: (task, name) for place, name in files.items()}
        return any([copy_object(self.store, name, place) for place, name in files.items()])


def files_of(store: Store, output: Output, path: Path) -> dict[Path, str]:
    """Name the objects of a file that is published to a path, by where each goes; those beside the file come first."""
    if not output.object.endswith(".set"):
        return {path: output.object}
    listing = read_listing(store, output.object)
    return {path.parent / name: part for name, part in listing.companions.items()} | {path: listing.path}


def copy_object(store: Store, name: str, path: Path) -> bool:
    """Copy the bytes of an object to a path unless they are there."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.is_file() and fingerprint(path, store) + ".bin" == name:
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
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
    return True
