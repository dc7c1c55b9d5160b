"""`{differences} FOLDER ...`: where the code of folders leaves its paper, in the words of its docstrings."""

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from sphinx.application import Sphinx

from extension.markdown import MarkdownDirective, escaped, joined

HOME = Path(__file__).resolve().parents[2]
SENTENCES = re.compile(r"We differ from (?:the paper|the sources)\b.*\.(?=\s|$)", re.DOTALL)


class Differences(MarkdownDirective):
    """The paragraphs that begin with "We differ from the paper", by file; an argument is a folder or a file."""

    def write(self) -> str:
        """Write a list."""
        given = [HOME / argument for argument in self.arguments]
        paths = [path for each in given for path in (sorted(each.rglob("*.py")) if each.is_dir() else [each])]
        found = [(path.relative_to(HOME).as_posix(), text) for path in paths for text in differences_in(path)]
        if not found:
            raise self.error("no docstring says where it differs from a paper")
        return joined(f"`{name}`\n: {text}" for name, text in found)


def differences_in(path: Path) -> Iterator[str]:
    """List what the docstrings of a file say of a difference, as Markdown."""
    for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(item, ast.Module | ast.ClassDef | ast.FunctionDef):
            for paragraph in re.split(r"\n\s*\n", inspect.cleandoc(ast.get_docstring(item) or "")):
                if match := SENTENCES.search(paragraph):
                    yield indented(match[0])


def indented(paragraph: str) -> str:
    """Write a paragraph, with its list if it has one, as the text of a definition."""
    lines = [escaped(line) for line in paragraph.splitlines()]
    return "\n  ".join("\n  " + line if line.startswith("- ") else line for line in lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("differences", Differences)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
