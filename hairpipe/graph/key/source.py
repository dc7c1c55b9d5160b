"""One Python source file: the digest of its code, and its imports."""

import ast
import json
import sys
from dataclasses import dataclass
from functools import cache

from hairpipe.graph.store.digest import digest_bytes

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

    @property
    def note(self) -> str:
        """The analysis as text."""
        return json.dumps([self.digest, self.imports])


def noted_source(note: str) -> Source:
    """Read an analysis from its note."""
    code, imports = json.loads(note)
    return Source(code, tuple((module, name) for module, name in imports))


@cache
def read_source(data: bytes, name: str) -> Source:
    """Analyse the bytes of a source file; SyntaxError or ValueError if it is not valid Python.

    Cached: a run reads sources for its keys, and again for its kernels.
    """
    tree = ast.parse(data, filename=name)
    imports = []
    for statement in ast.walk(tree):
        imports += imports_of(statement)
        strip_docstring(statement)
    text = ast.dump(tree, annotate_fields=False)
    return Source(digest_bytes("source", text.encode()), tuple(imports))


def strip_docstring(statement: ast.AST) -> None:
    """Remove the docstring of a module, class or function; in place."""
    if isinstance(statement, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        body = statement.body
        if body and isinstance(body[0], ast.Expr) and isinstance(getattr(body[0].value, "value", None), str):
            del body[0]


def imports_of(statement: ast.AST) -> list[tuple[str, str | None]]:
    """List the imports of a statement; `import a.b` also imports a, which it binds."""
    if isinstance(statement, ast.Import):
        return [(name, None) for alias in statement.names for name in reachable(alias)]
    if isinstance(statement, ast.ImportFrom):
        return [(origin(statement), alias.name) for alias in statement.names]
    return []


def reachable(alias: ast.alias) -> list[str]:
    """List the modules that can be used after `import a.b`: a and a.b; after `import a.b as c` it is a.b alone."""
    parts = alias.name.split(".")
    return [alias.name] if alias.asname else [".".join(parts[:depth]) for depth in range(1, len(parts) + 1)]


def origin(statement: ast.ImportFrom) -> str:
    """Return the module of `from module import ...`, with its dots."""
    return "." * statement.level + (statement.module or "")
