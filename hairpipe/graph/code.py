"""The code a node depends on: its module and, transitively, the first-party modules it imports.

Imports inside functions count; comments, docstrings and layout do not. `from package import name` leads to the module
that binds the name, not to everything else the package gathers. The engine itself does not count: it promises not to
change values.
"""

import importlib.metadata
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path

from hairpipe.graph.canonical import digest, digest_bytes
from hairpipe.graph.source import FORMAT, Source, read_source

ENGINE = "hairpipe.graph"
ALWAYS = ("numpy", "scipy", "numba")
DISTRIBUTIONS = {"pxr": "usd-core", "PIL": "pillow", "openvdb": "bpy"}
INSTALLED = ("site-packages", "dist-packages")

Remember = Callable[[str, Callable[[], str]], str]
"""Gives the text remembered under a name, or computes and keeps it."""


@dataclass(frozen=True)
class Code:
    """The digest of all code behind a node, and what it was made of, so that a plan can name what changed."""

    digest: str
    parts: dict[str, str]

    @property
    def manifest(self) -> str:
        """The parts as text."""
        return json.dumps(self.parts)


class CodeReader:
    """Digests the code behind modules; every file is read once and analysed only when its bytes are new.

    folder  of node types: whose files come first, as they do when they are loaded
    """

    def __init__(self, remember: Remember, folder: Path | None = None) -> None:
        self._remember, self._folder = remember, folder
        self._sources: dict[str, Source | None] = {}
        self._specs: dict[str, ModuleSpec | None] = {}

    def code_of(self, module: str) -> Code:
        """Digest a module with everything first-party behind it and the versions of what is not."""
        first_party, foreign = self._closure(module)
        parts = {name: source.digest for name in first_party if (source := self._source(name)) is not None}
        parts |= {f"{name} (version)": version(name) for name in sorted({*ALWAYS, *foreign})}
        return Code(digest("code", parts), parts)

    def kernel_sources(self, module: str) -> dict[str, str]:
        """Digests of the modules of others behind one, by name; none where not one of them compiles anything."""
        first_party = [name for name in self._closure(module)[0] if name.partition(".")[0] != "hairpipe"]
        known = {name: source for name in first_party if (source := self._source(name)) is not None}
        imported = {target.partition(".")[0] for source in known.values() for target, *_ in source.imports}
        return {name: source.digest for name, source in known.items()} if "numba" in imported else {}

    def own_digest(self, module: str) -> str:
        """Digest a first-party module without what it imports."""
        source = self._source(module)
        if source is None:
            raise ValueError(f"{module} is not first-party")
        return source.digest

    def _closure(self, module: str) -> tuple[list[str], set[str]]:
        """Walk the imports: first-party modules in name order, and names of foreign distributions."""
        found: set[str] = set()
        foreign: set[str] = set()
        queue = [module]
        while queue:
            name = queue.pop()
            if name in found or name == ENGINE or name.startswith(ENGINE + "."):
                continue
            source = self._source(name)
            if source is None:
                foreign |= {name.partition(".")[0]} - sys.stdlib_module_names
                continue
            found.add(name)
            queue.extend(self._imported(name, source))
        return sorted(found), foreign

    def _imported(self, module: str, source: Source) -> Iterator[str]:
        """Name the modules behind each import of a first-party module."""
        for target, name, _ in source.imports:
            target = self._absolute(module, target)
            yield target if name is None else self._binder(target, name, set())

    def _binder(self, module: str, name: str, seen: set[str]) -> str:
        """Find the module behind `from module import name`: a submodule, or where a re-export leads."""
        source = self._source(module)
        if source is None or name == "*" or name in source.defines or module in seen:
            return module
        for target, original, local in source.imports:
            if local == name and original not in (None, "*"):
                return self._binder(self._absolute(module, target), original, seen | {module})
        return f"{module}.{name}" if self._spec(f"{module}.{name}") else module

    def _absolute(self, module: str, target: str) -> str:
        """Resolve the leading dots of a relative import."""
        dots = len(target) - len(target.lstrip("."))
        if not dots:
            return target
        spec = self._spec(module)
        is_package = spec is not None and spec.submodule_search_locations is not None
        base = module.split(".")[: None if is_package and dots == 1 else (1 if is_package else 0) - dots]
        return ".".join([*base, target[dots:]]).rstrip(".")

    def _source(self, module: str) -> Source | None:
        """Analyse a first-party module; None for anything else."""
        if module not in self._sources:
            spec = self._spec(module)
            origin = spec.origin if spec is not None and is_first_party(module, spec) else None
            self._sources[module] = None if origin is None else self._read(Path(origin))
        return self._sources[module]

    def _read(self, path: Path) -> Source:
        data = path.read_bytes()

        def analyse() -> str:
            source = read_source(data, str(path))
            return json.dumps([source.digest, sorted(source.defines), source.imports])

        name = digest_bytes("source", FORMAT.encode() + b"\0" + data)
        code, defines, imports = json.loads(self._remember(name, analyse))
        return Source(code, frozenset(defines), tuple((m, n, local) for m, n, local in imports))

    def _spec(self, module: str) -> ModuleSpec | None:
        """Find a module without importing it or the packages above it."""
        if module not in self._specs:
            parent, _, _ = module.rpartition(".")
            above = self._spec(parent) if parent else None
            path = above.submodule_search_locations if above else None
            missing = bool(parent) and path is None
            self._specs[module] = self._beside(module) or (None if missing else find_spec(module, path))
        return self._specs[module]

    def _beside(self, module: str) -> ModuleSpec | None:
        """Find a module in the folder of node types, whatever else on the path has its name."""
        path = self._folder / f"{module}.py" if self._folder and module.isidentifier() else None
        return spec_from_file_location(module, path) if path and path.is_file() else None


def find_spec(module: str, path: list[str] | None) -> ModuleSpec | None:
    """Ask every finder for a module, as an import would."""
    found = (finder.find_spec(module, path, None) for finder in sys.meta_path if hasattr(finder, "find_spec"))
    return next((spec for spec in found if spec is not None), None)


def is_first_party(module: str, spec: ModuleSpec) -> bool:
    """Whether a module is ours or the user's: Python source that is neither stdlib nor an installed library."""
    top = module.partition(".")[0]
    if not spec.origin or not spec.origin.endswith(".py") or top in sys.stdlib_module_names:
        return False
    return top == "hairpipe" or not any(folder in Path(spec.origin).parts for folder in INSTALLED)


@cache
def version(name: str) -> str:
    """Version of the distribution that provides a top-level module, or "none"."""
    try:
        return importlib.metadata.version(DISTRIBUTIONS.get(name, name))
    except importlib.metadata.PackageNotFoundError:
        return "none"
