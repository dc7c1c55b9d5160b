"""`{ledger} FILE ...`: what files compute, in the words of their heads, the sources they cite, and their tests."""

import ast
import re
from functools import cache
from pathlib import Path

from sphinx.application import Sphinx

from extension.markdown import MarkdownDirective, escaped, table

HOME = Path(__file__).resolve().parents[2]
MOST_TESTS = 4  # of its own room first
CITED = re.compile(
    r"Sec\. \d+(?:\.\d+)*|Fig\. \d+\w?|[Ss]teps? \d(?:(?:, | and )\d)*|\(\d+\)(?: (?:to|and) \(\d+\))?"
    r"|[A-Z][\w-]+(?:, [A-Z][\w-]+)*(?: and [A-Z][\w-]+| et al\.)? (?:19|20)\d\d"
)
"""A section, figure, step or equation of a paper, or its authors and year."""


class Ledger(MarkdownDirective):
    """A row for each file; an argument is a file or a folder."""

    def write(self) -> str:
        """Write a table."""
        given = [HOME / argument for argument in self.arguments]
        paths = [path for each in given for path in (sorted(each.rglob("*.py")) if each.is_dir() else [each])]
        rows = [row_of(path) for path in paths if path.name != "__init__.py"]
        return table(("law or method", "file", "cites", "tests"), rows)


def row_of(path: Path) -> tuple[str, str, str, str]:
    """Describe a file by the first line of its docstring."""
    head = docstring_of(path).partition("\n")[0].strip()
    tests = [test.relative_to(HOME).as_posix() for test in tests_of(path)]
    tests.sort(key=lambda test: not test.startswith(f"tests/{path.parent.name}/"))
    named = ", ".join(f"`{test}`" for test in tests[:MOST_TESTS])
    more = f", {len(tests) - MOST_TESTS} more" if len(tests) > MOST_TESTS else ""
    return escaped(head), f"`{path.relative_to(HOME).as_posix()}`", ", ".join(citations_in(path)), named + more


def docstring_of(path: Path) -> str:
    """Return the docstring of a module, or nothing."""
    return ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""


def citations_in(path: Path) -> list[str]:
    """List what the head of a file cites, each once."""
    text = " ".join(docstring_of(path).split())
    return list(dict.fromkeys(CITED.findall(text)))


def tests_of(path: Path) -> list[Path]:
    """List the tests that import a module."""
    module = ".".join(path.relative_to(HOME).with_suffix("").parts)
    module = module if module.startswith("hairpipe.") else f"hairpipe.{module}"
    return [test for test, names in _imports_of_tests().items() if module in names]


@cache
def _imports_of_tests() -> dict[Path, set[str]]:
    """Return the modules that each test imports, and what it imports from them."""
    found = {}
    for test in sorted((HOME / "tests").rglob("test_*.py")):
        items = list(ast.walk(ast.parse(test.read_text(encoding="utf-8"))))
        names = {alias.name for item in items if isinstance(item, ast.Import) for alias in item.names}
        for item in items:
            if isinstance(item, ast.ImportFrom):
                names |= {str(item.module), *(f"{item.module}.{alias.name}" for alias in item.names)}
        found[test] = names
    return found


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("ledger", Ledger)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
