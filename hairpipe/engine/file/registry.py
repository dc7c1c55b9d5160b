"""Registry of node types: ours, those of installed packages, and those in a trusted folder next to the graph file.

A file declares one node type of the same name; there is no registration. Only node types in use are imported.
"""

import importlib
import importlib.metadata
import importlib.util
import pkgutil
import sys
from contextlib import redirect_stdout, suppress
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType

from hairpipe.engine.file.trust import trust_error
from hairpipe.engine.node.declare import NodeType
from hairpipe.engine.node.import_paths import EXPERIMENTS, OUR_NODES, UncompiledLoader, enter, folder_of, leads_to
from hairpipe.engine.node.messages import nearest
from hairpipe.engine.node.settings import fields_of
from hairpipe.errors import BadInput

ENTRY_POINTS = "hairpipe.nodes"


class Registry:
    """Node types by name.

    folder  of further node types, which take precedence; top-level imports search it last, once it is trusted.
            None for our own folder, next to a graph in the root of a checkout: every graph finds its package
    """

    def __init__(self, folder: Path | None = None) -> None:
        ours = folder_of(OUR_NODES)
        own = folder is not None and folder.is_dir() and not (ours and folder.samefile(ours))
        self.folder = folder if own else None
        self._known: dict[str, NodeType] = {}

    @cached_property
    def _trust_error(self) -> BadInput | None:
        return trust_error(self.folder) if self.folder else None

    @cached_property
    def _ours(self) -> frozenset[str]:
        """Node types of our own package: to find them imports no other."""
        return frozenset(modules_in(OUR_NODES))

    @cached_property
    def _packaged(self) -> dict[str, str]:
        """Packages of the node types outside the folder, by name; the first package that has one."""
        return {name: package for package in reversed(packages()) for name in modules_in(package)}

    def names(self) -> list[str]:
        """List the names of all node types, without importing them."""
        local = [path.stem for path in self.folder.glob("*.py")] if self.folder else []
        return sorted(name for name in {*local, *self._packaged} if not name.startswith("_"))

    def find(self, name: str) -> NodeType:
        """Import a node type; BadInput if the name is unknown, or its file declares no node type or is not trusted."""
        if name not in self._known:
            try:
                with redirect_stdout(sys.stderr):  # output of a file that is imported must not mix with results
                    module = self._import(name)
            except BadInput:
                raise
            except Exception as error:  # an import may raise anything
                what = f"node type '{name}' cannot be loaded: {type(error).__name__}: {error}"
                raise BadInput(what) from error
            self._known[name] = declared_in(module, name)
        return self._known[name]

    def types_with_output(self, kind: type) -> list[str]:
        """List the node types with an output of a type; those that cannot be imported are omitted."""
        found = []
        for name in self.names():
            with suppress(BadInput):
                found += [name] if kind in self.find(name).outputs.values() else []
        return found

    def _import(self, name: str) -> ModuleType:
        if self.folder:
            path = self.folder / f"{name}.py"
            own = name.isidentifier() and path.is_file()
            if own and self._trust_error:
                raise self._trust_error
            if not self._trust_error:
                enter(self.folder)
            if own:
                return load_file(name, path)
        package = OUR_NODES if name in self._ours else self._packaged.get(name)
        if package is None:
            right = nearest(name, self.names())
            experiments = folder_of(EXPERIMENTS)
            if experiments and name in modules_in(EXPERIMENTS):
                right = f"only graphs in {experiments.parent} find it"
            raise BadInput(f"no node type '{name}'", right=right)
        return importlib.import_module(f"{package}.{name}")


@cache
def packages() -> list[str]:
    """List the packages of node types: ours, then those of the entry points."""
    found = importlib.metadata.entry_points(group=ENTRY_POINTS)
    return list(dict.fromkeys([OUR_NODES, *(entry.value for entry in found)]))


def modules_in(package: str) -> list[str]:
    """List the public modules of a package; none where it cannot be imported."""
    try:
        with redirect_stdout(sys.stderr):
            paths = importlib.import_module(package).__path__
    except Exception:  # a broken package must not break the others
        return []
    return [module.name for module in pkgutil.iter_modules(paths) if not module.name.startswith("_")]


def load_file(name: str, path: Path) -> ModuleType:
    """Import a file as a top-level module; it is added to `sys.modules` only if an import of its name finds it."""
    spec = importlib.util.spec_from_file_location(name, path, loader=UncompiledLoader(name, str(path)))
    if name in sys.stdlib_module_names or spec is None or spec.loader is None:
        raise BadInput(f"{path.name} hides a module of Python", right="another file name")
    module = importlib.util.module_from_spec(spec)
    if leads_to(name, path):
        sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def declared_in(module: ModuleType, name: str) -> NodeType:
    """Return the node type that a module declares; BadInput if there is none."""
    found = getattr(getattr(module, name, None), "__node__", None)
    if not isinstance(found, NodeType) or found.module != module.__name__:
        raise BadInput(f"{module.__file__} declares no node", right=f"@node(...) def {name}(...), named as its file")
    try:
        fields_of(found)
    except TypeError as error:
        raise BadInput(str(error), where=module.__file__, right="numbers, texts, choices, files, groups") from None
    return found
