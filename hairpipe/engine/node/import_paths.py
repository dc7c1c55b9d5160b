"""Import paths: the folder of node types is the last entry of `sys.path`, for keys and for workers.

So files of a user cannot hide libraries that our own code imports.
"""

import importlib
import sys
from importlib.machinery import (
    BYTECODE_SUFFIXES,
    EXTENSION_SUFFIXES,
    SOURCE_SUFFIXES,
    ExtensionFileLoader,
    FileFinder,
    ModuleSpec,
    SourceFileLoader,
    SourcelessFileLoader,
)
from pathlib import Path
from types import ModuleType
from typing import NoReturn

import hairpipe
from hairpipe.child import withheld

HOUSE = "hairpipe"
OUR_NODES = f"{HOUSE}.nodes"
"""Package of the node types of all graphs: the folder `nodes` of a checkout."""
EXPERIMENTS = f"{HOUSE}.graphs.experiments.nodes"
"""Package of the node types of graphs in `graphs/experiments`; it exists in a checkout only."""

_folders: set[str] = set()
"""Folders that are or were on the path."""


def folder_of(package: str) -> Path | None:
    """Find the folder of a package; None if it is not installed."""
    try:
        return Path(importlib.import_module(package).__path__[0])
    except ModuleNotFoundError:
        return None


class UncompiledLoader(SourceFileLoader):
    """Imports a source file without cached bytecode: that of another file can have the same size and time."""

    def path_stats(self, path: str) -> NoReturn:
        """Raise OSError: no bytecode is read or written."""
        raise OSError


def finder(path: str) -> FileFinder:
    """Return the finder of a folder of node types, or of one within it; ImportError for others."""
    if _folders.isdisjoint((path, *map(str, Path(path).parents))):
        raise ImportError
    kinds = (
        (ExtensionFileLoader, EXTENSION_SUFFIXES),
        (UncompiledLoader, SOURCE_SUFFIXES),
        (SourcelessFileLoader, BYTECODE_SUFFIXES),
    )
    return FileFinder(path, *kinds)


sys.path_hooks.insert(0, finder)


def enter(folder: Path) -> None:
    """Replace the folder of node types on `sys.path`, and unload the modules of the previous one.

    So graphs that are loaded in turn can import modules of the same name.
    """
    name = str(folder.absolute())
    _folders.add(name)
    sys.path_importer_cache.pop(name, None)  # it may not have seen a file that has just been written
    for other in [other for other in withheld if other != name]:
        leave(other)
    if name not in sys.path and folder.is_dir():
        sys.path.append(name)
        withheld.append(name)


def leave(folder: str) -> None:
    """Remove a folder from `sys.path`, and unload the top-level modules that were imported from it."""
    gone = {name for name, module in sys.modules.items() if "." not in name and lies_in(module, folder)}
    for name in [name for name in sys.modules if name.partition(".")[0] in gone]:
        del sys.modules[name]
    sys.path[:] = [path for path in sys.path if path != folder]
    withheld[:] = [other for other in withheld if other != folder]


def lies_in(module: ModuleType, folder: str) -> bool:
    known = vars(module) if isinstance(module, ModuleType) else {}
    places = [known.get("__file__"), *(known.get("__path__") or ())]
    return any(Path(place).is_relative_to(folder) for place in places if place)


def find_spec(module: str, path: list[str] | None) -> ModuleSpec | None:
    """Find a module as an import would; None if it is unknown."""
    if module == HOUSE:  # imported already, whatever file of the folder has its name
        return hairpipe.__spec__
    found = (finder.find_spec(module, path, None) for finder in sys.meta_path if hasattr(finder, "find_spec"))
    try:
        return next((spec for spec in found if spec is not None), None)
    except KeyError:  # for nested namespaces, Python asks the outer one, which is not imported here
        spec = ModuleSpec(module, None, is_package=True)
        folders = [Path(place, module.rpartition(".")[2]) for place in path or ()]
        spec.submodule_search_locations = [str(folder) for folder in folders if folder.is_dir()]
        return spec


def leads_to(module: str, path: Path) -> bool:
    """Whether an import of a top-level module finds this file."""
    spec = find_spec(module, None)
    return spec is not None and spec.has_location and spec.origin is not None and path.samefile(spec.origin)


def is_namespace(spec: ModuleSpec | None) -> bool:
    """Whether a module is a namespace package."""
    return spec is not None and spec.origin is None and spec.submodule_search_locations is not None
