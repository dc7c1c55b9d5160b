"""The program that a process runs: interpreter, import path, installed packages, and the files of our own code."""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import hairpipe
from hairpipe.child import search_path
from hairpipe.graph.node.import_paths import OUR_NODES, folder_of
from hairpipe.graph.store.digest import digest_bytes

INSTALLED = ("site-packages", "dist-packages")


def program_digest(*folders: Path) -> str:
    """Digest the stamps of everything that a new process would import: it differs after any change of code or versions.

    folders  of further code
    """
    ours = [Path(hairpipe.__file__).parent, folder_of(OUR_NODES), *folders]
    path = search_path()
    packages = [Path(entry) for entry in path if Path(entry).name in INSTALLED]
    files = [file for folder in ours if folder is not None for file in sources_below(folder)]
    stamps = {str(place): stamp(place) for place in (Path(sys.executable), *packages, *files)}
    return digest_bytes("program", json.dumps([path, sys.version, stamps]).encode())


def sources_below(folder: Path) -> Iterator[Path]:
    """Iterate over the Python files of a folder, in order; none if it does not exist."""
    for place, folders, names in os.walk(folder):
        folders.sort()
        yield from (Path(place, name) for name in sorted(names) if name.endswith(".py"))


def stamp(place: Path) -> list[int]:
    """Return inode, size and modification of a file or folder; empty if it does not exist."""
    try:
        status = place.stat()
    except OSError:
        return []
    return [status.st_ino, status.st_size, status.st_mtime_ns]
