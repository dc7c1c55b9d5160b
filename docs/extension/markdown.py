"""Markdown that directives write: what they read from the code becomes Markdown, which MyST parses in their place."""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

CODE = re.compile(r"(`[^`]*`)")
PARAMETER = re.compile(r"(\*{0,2}\w+(?:, \w+)*) {2,}(\S.*)")
"""A line of a docstring that explains a parameter: names, two blanks or more, and a text."""


class MarkdownDirective(SphinxDirective, ABC):
    """A directive whose content is Markdown that `write` returns; headings in it are sections of the page.

    prefix    of the labels by which `{ref}` finds the sections
    labelled  whether they have any
    """

    prefix, labelled = "", False

    has_content = True
    optional_arguments = 100

    @abstractmethod
    def write(self) -> str:
        """Return the Markdown that stands for the directive."""

    def run(self) -> list[nodes.Node]:
        """Parse the Markdown in place of the directive."""
        found = nodes.Element()
        lines = StringList(self.write().splitlines(), self.env.docname)
        self.state.nested_parse(lines, self.content_offset, found, match_titles=True)
        # MyST appends sections to the section of the page that the directive is in.
        for section in self.state.document.findall(nodes.section) if self.labelled else ():
            title = section[0].astext()
            label = nodes.fully_normalize_name(self.prefix + title)
            self.env.domains.standard_domain.note_hyperlink_target(label, self.env.docname, section["ids"][0], title)
        return found.children


def escaped(text: str) -> str:
    """Escape what Markdown would take for marks, outside of code spans."""
    parts = CODE.split(text)
    return "".join(
        part if place % 2 else re.sub(r"([\\*_<>\[\]#|{}$~^])", r"\\\1", part) for place, part in enumerate(parts)
    )


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table; cells are Markdown. Nothing where there are no rows."""
    body = [[cell.replace("\n", " ").replace("|", "\\|").replace("\\\\|", "\\|") for cell in row] for row in rows]
    if not body:
        return ""
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *body))


def fence(language: str, text: str) -> str:
    """Write a block of code."""
    return f"```{language}\n{text.rstrip()}\n```"


def joined(parts: Iterable[str]) -> str:
    """Join blocks of Markdown; empty ones are left out."""
    return "\n\n".join(part for part in parts if part)


def docstring(text: str) -> str:
    """Write a docstring as Markdown: lines `name  text` are a list of definitions, indented ones are code."""
    return joined(block(lines) for lines in blocks_of(text))


def blocks_of(text: str) -> list[list[str]]:
    """Split a text at its blank lines."""
    return [part.splitlines() for part in re.split(r"\n\s*\n", text.strip("\n")) if part.strip()]


def block(lines: list[str]) -> str:
    """Write a paragraph of a docstring."""
    if PARAMETER.match(lines[0].strip()) and not lines[0].strip().endswith(":"):
        return parameters(lines)
    if all(line.startswith("    ") for line in lines):
        return fence("python", "\n".join(line[4:] for line in lines))
    return escaped(" ".join(line.strip() for line in lines))


def parameters(lines: list[str]) -> str:
    """Write lines `name  text`, each with lines that continue it, as a list of definitions."""
    found: list[tuple[str, list[str]]] = []
    for line in lines:
        match = PARAMETER.match(line.strip())
        indent = len(line) - len(line.lstrip())
        if match and (not found or indent == len(lines[0]) - len(lines[0].lstrip())):
            found.append((match[1], [match[2]]))
        else:
            found[-1][1].append(line.strip())
    return "\n\n".join(f"`{name}`\n: {escaped(' '.join(texts))}" for name, texts in found)
