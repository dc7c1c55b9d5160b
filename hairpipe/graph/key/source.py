"""What one Python source file is and needs: the digest of its code, the names it binds and the imports it makes."""

import ast
import json
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from hairpipe.graph.store.digest import digest_bytes

FORMAT = f"source 2, Python {sys.version_info.major}.{sys.version_info.minor}"
"""Enters the name under which a finding is remembered: another Python prints another tree."""
SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
"""What is bound within these is not bound in the module."""
STAR = "*"

Lead = tuple[str, str]
"""(module, name) of a `from module import name`; dots of a relative import still lead the module."""


@dataclass(frozen=True)
class Source:
    """What matters of a source file.

    digest   of the syntax tree without comments, docstrings and layout
    binds    names bound at module level, and where each leads: to (module, name) where a single `from module import
             name`, which no condition stands above, binds it; else None. "*" stands for all that a star import binds
    imports  (module, name) of `from module import name` and (module, None) of `import module`, anywhere in the file
    """

    digest: str
    binds: dict[str, Lead | None]
    imports: tuple[tuple[str, str | None], ...]

    @property
    def note(self) -> str:
        """All of it as text."""
        return json.dumps([self.digest, self.binds, self.imports])


def noted_source(note: str) -> Source:
    """Take a source back out of its note."""
    code, binds, imports = json.loads(note)
    leads = {name: (lead[0], lead[1]) if lead else None for name, lead in binds.items()}
    return Source(code, leads, tuple((module, name) for module, name in imports))


@cache
def read_source(data: bytes, name: str) -> Source:
    """Analyse the bytes of a source file; SyntaxError or ValueError where Python could not import it either.

    Once a process: a run reads sources for its keys, and again for its kernels.
    """
    tree = ast.parse(data, filename=name)
    imports = []
    for statement in ast.walk(tree):
        imports += imports_of(statement)
        strip_docstring(statement)
    text = ast.dump(tree, annotate_fields=False)
    return Source(digest_bytes("source", text.encode()), bindings(tree), tuple(imports))


def strip_docstring(statement: ast.AST) -> None:
    """Remove the docstring of a module, class or function; in place."""
    if isinstance(statement, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        body = statement.body
        if body and isinstance(body[0], ast.Expr) and isinstance(getattr(body[0].value, "value", None), str):
            del body[0]


def imports_of(statement: ast.AST) -> list[tuple[str, str | None]]:
    """List the imports that a statement makes; `import a.b` gives a too, which is what it binds."""
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
    """Write the module of `from module import ...`, with its dots."""
    return "." * statement.level + (statement.module or "")


def bindings(tree: ast.Module) -> dict[str, Lead | None]:
    """Map each name that a module binds to where it leads, as in `Source.binds`."""
    counts = Counter(name for item in outside_functions(tree) if (name := bound_by(item)))
    counts.update(name for item in ast.walk(tree) if isinstance(item, ast.Global) for name in item.names)
    leads = {
        alias.asname or alias.name: (origin(statement), alias.name)
        for statement in tree.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }
    clear = STAR not in counts  # a star import may bind any name anew
    return {name: leads.get(name) if clear and count == 1 else None for name, count in counts.items()}


def outside_functions(tree: ast.Module) -> Iterator[ast.AST]:
    """Walk a module, under its conditions too but not into functions and classes."""
    queue: list[ast.AST] = [tree]
    while queue:
        item = queue.pop()
        yield item
        queue.extend(evaluated_here(item) if isinstance(item, SCOPES) else ast.iter_child_nodes(item))


def evaluated_here(scope: ast.AST) -> Iterator[ast.AST]:
    """Give the parts of a function or class that are evaluated where it stands: all but its body and parameters."""
    for name, value in ast.iter_fields(scope):
        if isinstance(value, ast.arguments):
            yield from filter(None, [*value.defaults, *value.kw_defaults])
        elif name != "body":
            yield from (part for part in (value if isinstance(value, list) else [value]) if isinstance(part, ast.AST))


def bound_by(item: ast.AST) -> str | None:
    """Name what a part of the syntax tree binds, or unbinds: by itself, without the parts within."""
    if isinstance(item, ast.Name):
        return None if isinstance(item.ctx, ast.Load) else item.id
    if isinstance(item, ast.alias):
        return item.asname or item.name.partition(".")[0]
    name = getattr(item, "name", None) or getattr(item, "rest", None)  # def, class, except, case
    return name if isinstance(name, str) else None
