"""`{interface}`: functions and classes of Python, as their signatures and docstrings describe them."""

import ast
import importlib
import inspect
import textwrap
from collections.abc import Iterator
from typing import Any

from sphinx.application import Sphinx

from extension.markdown import MarkdownDirective, docstring, fence, joined


class Interface(MarkdownDirective):
    """Objects by their dotted names, a line each; or the values that a package exports, without their methods."""

    prefix = "value-"

    def write(self) -> str:
        """Describe every object; values get a label, by which nodes link to their types."""
        packages = map(importlib.import_module, self.arguments)
        values = [f"{package.__name__}.{name}" for package in packages for name in package.__all__]
        self.labelled = bool(values)
        names = values or [line for line in self.content if line]
        return joined(describe(name.rpartition(".")[2], find(name), bare=bool(values)) for name in names)


def find(name: str) -> Any:
    """Import an object by its dotted name."""
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(module), last)


def describe(name: str, item: Any, *, bare: bool) -> str:
    """Describe an object, below a heading of its name, and its public members below that unless it is bare."""
    members = [] if bare else [f"### {name}.{inner}\n\n{text}" for inner, text in members_of(item)]
    return joined([f"## {name}", signature(name, item), words_of(item), *members])


def members_of(item: Any) -> Iterator[tuple[str, str]]:
    """List the public methods and properties of a class, in the order of its source."""
    for name, member in vars(item).items() if inspect.isclass(item) else ():
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, property)):
            yield name, joined(["" if isinstance(member, property) else signature(name, member), words_of(member)])


def signature(name: str, function: Any) -> str:
    """Write the call of a function, with annotations as in its source; nothing for a class."""
    if inspect.isclass(function):
        return ""
    [read] = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(read, ast.FunctionDef)
    read.args.args = [argument for argument in read.args.args if argument.arg != "self"]
    bare = ast.FunctionDef(name, read.args, [ast.Pass()], [], read.returns, lineno=1)
    call = ast.unparse(ast.fix_missing_locations(bare)).removeprefix("def ").partition(":\n")[0]
    return fence("python", call.replace("'", ""))


def words_of(item: Any) -> str:
    """Write the docstring of an object."""
    return docstring(inspect.getdoc(item) or "")


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("interface", Interface)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
