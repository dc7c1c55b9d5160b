"""What one Python source file is and needs: the digest of its code, the names it defines and the imports it makes."""

import ast
import sys
from dataclasses import dataclass
from functools import cache

from hairpipe.graph.canonical import digest_bytes

FORMAT = f"source 1, Python {sys.version_info.major}.{sys.version_info.minor}"
"""Enters the name under which a finding is remembered: another Python prints another tree."""


@dataclass(frozen=True)
class Source:
    """What matters of a source file.

    digest   of the syntax tree without comments, docstrings and layout
    defines  names bound at the top level by anything but an import
    imports  (module, name or None, local name): `from module import name as local`, `import module`;
             dots of a relative import still lead the module
    """

    digest: str
    defines: frozenset[str]
    imports: tuple[tuple[str, str | None, str], ...]


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
    return Source(digest_bytes("source", text.encode()), frozenset(definitions(tree)), tuple(imports))


def strip_docstring(statement: ast.AST) -> None:
    """Remove the docstring of a module, class or function; in place."""
    if isinstance(statement, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        body = statement.body
        if body and isinstance(body[0], ast.Expr) and isinstance(getattr(body[0].value, "value", None), str):
            del body[0]


def imports_of(statement: ast.AST) -> list[tuple[str, str | None, str]]:
    """List the imports that a statement makes."""
    if isinstance(statement, ast.Import):
        return [(alias.name, None, alias.asname or alias.name) for alias in statement.names]
    if isinstance(statement, ast.ImportFrom):
        module = "." * statement.level + (statement.module or "")
        return [(module, alias.name, alias.asname or alias.name) for alias in statement.names]
    return []


def definitions(tree: ast.Module) -> set[str]:
    """Collect the names that a module binds itself."""
    named = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    names = {node.name for node in tree.body if isinstance(node, named)}
    stored = (node for statement in tree.body if not isinstance(statement, named) for node in ast.walk(statement))
    return names | {node.id for node in stored if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
