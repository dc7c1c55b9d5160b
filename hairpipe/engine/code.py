"""Code of a node: its module and, transitively, the imported first-party modules.

Imports inside functions are included; comments, docstrings and layout are not. A module is included as a whole, with
all its imports: `from package import name` includes the package, and the module of that name if there is one; `import
package.module` includes both. So importers of a package that re-exports its modules depend on all of them. The engine
is excluded, as it must not change values. The class of the processor is included, as the last bits of results depend
on it.

One Python source file: the digest of its code, and its imports.
"""

import ast
import importlib.metadata
import json
import pkgutil
import sys
import time
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import astuple, dataclass
from functools import cache
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from typing import Self

from hairpipe.engine.file.trust import trust_error
from hairpipe.engine.node.import_paths import HOUSE, enter, find_spec, is_namespace, leads_to
from hairpipe.engine.store.digest import digest, digest_bytes
from hairpipe.engine.store.fingerprint import is_settled
from hairpipe.errors import BadInput
from hairpipe.plain_file import Stamp, stamp_of
from hairpipe.processor import processor_class

FORMAT = f"source 3, Python {sys.version_info.major}.{sys.version_info.minor}"
"""Part of the name of a stored analysis: syntax trees depend on the version of Python."""
STAR = "*"


@dataclass(frozen=True)
class Source:
    """Digest and imports of a source file.

    digest   of the syntax tree without comments, docstrings and layout
    imports  (module, name) of `from module import name` and (module, None) of `import module`, anywhere in the file;
             with the leading dots of a relative import
    """

    digest: str
    imports: tuple[tuple[str, str | None], ...]


@cache
def read_source(data: bytes, name: str) -> Source:
    """Analyse the bytes of a source file; SyntaxError or ValueError if it is not valid Python.

    Cached: a run reads sources for its keys, and again for its kernels.
    """
    tree = ast.parse(data, filename=name)
    imports = []
    for statement in ast.walk(tree):
        imports += imports_of(statement)
        is_scope = isinstance(statement, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if is_scope and ast.get_docstring(statement, clean=False) is not None:
            del statement.body[0]
    text = ast.dump(tree, annotate_fields=False)
    return Source(digest_bytes("source", text.encode()), tuple(imports))


def imports_of(statement: ast.AST) -> list[tuple[str, str | None]]:
    """List the imports of a statement; `import a.b` also imports a, which it binds."""
    if isinstance(statement, ast.Import):
        return [(name, None) for alias in statement.names for name in reachable(alias)]
    if isinstance(statement, ast.ImportFrom):
        origin = "." * statement.level + (statement.module or "")
        return [(origin, alias.name) for alias in statement.names]
    return []


def reachable(alias: ast.alias) -> list[str]:
    """List the modules that can be used after `import a.b`: a and a.b; after `import a.b as c` it is a.b alone."""
    parts = alias.name.split(".")
    return [alias.name] if alias.asname else [".".join(parts[:depth]) for depth in range(1, len(parts) + 1)]


ENGINE = ("hairpipe.engine.", "hairpipe.app.api.")
"""The engine, and the interface to it."""
ALWAYS = ("numpy", "scipy", "numba")
DISTRIBUTIONS = {"pxr": "usd-core", "PIL": "pillow"}
INSTALLED = ("site-packages", "dist-packages")
NO_VERSION = "none"

_settled: dict[Path, tuple[Stamp, Source]] = {}
"""Analyses of files with their stamps, so that a process reads code once for many graphs."""

Remember = Callable[[str, Callable[[], str]], str]
"""Returns the text stored by a name, or computes and stores it."""


@dataclass(frozen=True)
class Code:
    """Digest of all code of a node, and of its parts, so that plans can list changed modules."""

    digest: str
    parts: dict[str, str]

    @property
    def manifest(self) -> str:
        return json.dumps(self.parts)


class CodeReader:
    """Digests the code of modules; every file is read once, and analysed only if its bytes are new.

    folder  of node types: it contains the files of nodes, and imports search it last, once it is trusted
    stamps  of the files by path, taken before reading
    """

    def __init__(self, remember: Remember, folder: Path | None = None) -> None:
        self._remember = remember
        self._folder = folder if folder and trust_error(folder) is None else None
        self.stamps: dict[str, Stamp] = {}
        self._sources: dict[str, Source | None] = {}
        self._specs: dict[str, ModuleSpec | None] = {}
        self._imports: dict[str, set[str]] = {}

    def with_notes(self, remember: Remember) -> Self:
        """Return a reader that shares what this one has read, and stores analyses elsewhere."""
        other = copy(self)
        other._remember = remember
        return other

    def code_of(self, module: str) -> Code:
        """Digest a module with its first-party imports, and the versions of other imports."""
        first_party, foreign = self._closure(module)
        parts = {name: source.digest for name in first_party if (source := self._source(name)) is not None}
        parts |= {f"{name} (version)": version(name) for name in sorted({*ALWAYS, *foreign})}
        parts["processor (class)"] = processor_class()
        return Code(digest("code", parts), parts)

    def modules_with_kernels(self, module: str) -> list[str]:
        """List the imported modules that are not ours; none if none of them imports numba."""
        first_party = [name for name in self._closure(module)[0] if name.partition(".")[0] != HOUSE]
        known = [source for name in first_party if (source := self._source(name)) is not None]
        imported = {target.partition(".")[0] for source in known for target, _ in source.imports}
        return first_party if "numba" in imported else []

    def own_digest(self, module: str) -> str:
        """Digest a first-party module without its imports."""
        source = self._source(module)
        if source is None:
            raise ValueError(f"{module} is not first-party")
        return source.digest

    def file_of(self, module: str) -> str:
        spec = self._spec(module)
        if spec is None or spec.origin is None:
            raise ValueError(f"{module} has no file")
        return spec.origin

    def _closure(self, module: str) -> tuple[list[str], set[str]]:
        """Follow the imports; return first-party modules in order, and names of other top-level modules."""
        if self._folder:
            enter(self._folder)
        found: set[str] = set()
        foreign: set[str] = set()
        queue = [self._own(module)]
        while queue:
            name = queue.pop()
            if name in found:
                continue
            source = self._source(name)
            if source is not None:
                found.add(name)
                queue.extend(self._imported(name, source) - found)
            elif not is_namespace(self._spec(name)):
                foreign |= {name.partition(".")[0]} - sys.stdlib_module_names
        return sorted(found), foreign

    def _own(self, module: str) -> str:
        """Return the name of a node in the folder, a special one if an import of it finds another file."""
        path = self._folder / f"{module}.py" if self._folder and module.isidentifier() else None
        if path is None or not path.is_file() or leads_to(module, path):
            return module
        name = f"{path.parent.name}/{module}"
        self._specs[name] = spec_from_file_location(module, path)
        return name

    def _imported(self, module: str, source: Source) -> set[str]:
        """Return the imports of a first-party module, without those of the engine."""
        if module in self._imports:
            return self._imports[module]
        found: set[str] = set()
        for target, name in source.imports:
            target = self._absolute(module, target)
            if target:  # a relative import outside of a package fails
                found.add(target)
                found |= self._submodules(target) if name == STAR else self._submodule(target, name)
        self._imports[module] = {name for name in found if not f"{name}.".startswith(ENGINE)}
        return self._imports[module]

    def _submodule(self, module: str, name: str | None) -> set[str]:
        return {f"{module}.{name}"} if name and self._spec(f"{module}.{name}") else set()

    def _submodules(self, module: str) -> set[str]:
        """Return the direct submodules of a package, which a star import can import."""
        spec = self._spec(module)
        paths = spec.submodule_search_locations if spec else None
        return {f"{module}.{inner.name}" for inner in pkgutil.iter_modules(paths)} if paths else set()

    def _absolute(self, module: str, target: str) -> str:
        dots = len(target) - len(target.lstrip("."))
        if not dots:
            return target
        spec = self._spec(module)
        is_package = spec is not None and spec.submodule_search_locations is not None
        base = module.split(".")[: None if is_package and dots == 1 else (1 if is_package else 0) - dots]
        return ".".join([*base, target[dots:]]).rstrip(".")

    def _source(self, module: str) -> Source | None:
        if module not in self._sources:
            spec = self._spec(module)
            origin = spec.origin if spec is not None and is_first_party(module, spec) else None
            self._sources[module] = None if origin is None else self._read(Path(origin))
        return self._sources[module]

    def _read(self, path: Path) -> Source:
        """Analyse a file; once per process while its stamp proves it unchanged."""
        try:
            begun = time.time_ns()
            stamp = stamp_of(str(path))
            self.stamps.setdefault(str(path), stamp)
            known, source = _settled.get(path, (None, None))
            if source is None or known != stamp:
                source = self._analysed(path)
                if is_settled(stamp, begun):
                    _settled[path] = stamp, source
            return source
        except SyntaxError as error:
            raise BadInput(f"cannot be read: {error.msg}", where=f"{path}:{error.lineno or 1}") from None
        except OSError as error:
            raise BadInput(f"cannot be read: {error.strerror}", where=path) from None
        except (ValueError, RecursionError) as error:
            raise BadInput(f"cannot be read: {error}", where=path) from None

    def _analysed(self, path: Path) -> Source:
        """Analyse the bytes of a source file; digest those of other files."""
        data = path.read_bytes()
        if path.suffix != ".py":
            return Source(digest_bytes("compiled", data), ())
        name = digest_bytes("source", FORMAT.encode() + b"\0" + data)
        code, imports = json.loads(self._remember(name, lambda: json.dumps(astuple(read_source(data, str(path))))))
        return Source(code, tuple((module, name) for module, name in imports))

    def _spec(self, module: str) -> ModuleSpec | None:
        if module not in self._specs:
            parent, _, _ = module.rpartition(".")
            above = self._spec(parent) if parent else None
            path = above.submodule_search_locations if above else None
            missing = bool(parent) and path is None
            self._specs[module] = None if missing else find_spec(module, path)
        return self._specs[module]


def is_first_party(module: str, spec: ModuleSpec) -> bool:
    """Whether a module is ours or the user's: a file that is neither stdlib nor of an installed distribution."""
    top = module.partition(".")[0]
    if not spec.has_location or not spec.origin or top in sys.stdlib_module_names:
        return False
    installed = any(folder in Path(spec.origin).parts for folder in INSTALLED)
    return top == HOUSE or not installed or version(top) == NO_VERSION


@cache
def version(name: str) -> str:
    """Return the version of the distribution of a top-level module, or "none"."""
    try:
        return importlib.metadata.version(DISTRIBUTIONS.get(name, name))
    except importlib.metadata.PackageNotFoundError:
        found = providers().get(name, []) if find_spec(name, None) else []
        return ", ".join(f"{other} {importlib.metadata.version(other)}" for other in sorted(set(found))) or NO_VERSION


@cache
def providers() -> Mapping[str, list[str]]:
    """Return distributions by top-level module; read once, as all metadata is opened."""
    return importlib.metadata.packages_distributions()
