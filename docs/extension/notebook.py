"""`python docs/extension/notebook.py`: write the third tutorial as a notebook.

A block of a page is a cell: text, a file that the reader saves, Python, or commands of the terminal. A comment of MyST,
`% ...`, is Python that only the notebook has.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path

TUTORIAL = Path(__file__).resolve().parents[1] / "tutorials/node.md"
BLOCK = re.compile(r"^```(\w*)\n([\s\S]*?)^```\n|((?:^ {4}.*\n)+)|((?:^% .*\n)+)", re.MULTILINE)
TABLE = re.compile(r"\n(?=\[[^\].]+\])")
NODE = re.compile(r"^@node.*\ndef (\w+)", re.MULTILINE)
GRAPH = re.compile(r"# (in )?([\w-]+\.toml)\b")
FIRST = 'import os\n\nos.makedirs("nodes", exist_ok=True)'
"""What the notebook begins with: the folder of nodes."""


def notebook_of(page: str) -> str:
    """Write a page as a notebook; pure."""
    cells = [cell("code", FIRST, 0)]
    for kind, text in blocks_of(page):
        cells.append(cell(kind, text, len(cells)))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    document = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(document, indent=1) + "\n"


def blocks_of(page: str) -> Iterator[tuple[str, str]]:
    """List the cells of a page: their kind, and their text."""
    graphs: dict[str, dict[str, str]] = {}
    end = 0
    for block in BLOCK.finditer(page):
        yield from prose(page[end : block.start()])
        language, code, commands, comments = block.groups()
        if commands:
            yield "code", "\n".join(f"!{line.strip()}" for line in commands.splitlines())
        elif comments:
            yield "code", "\n".join(line.removeprefix("% ") for line in comments.splitlines())
        else:
            yield "code", graph(code, graphs) if language == "toml" else python(code)
        end = block.end()
    yield from prose(page[end:])


def prose(text: str) -> Iterator[tuple[str, str]]:
    """Yield a cell of text, without roles that only pages have; none where no text is left."""
    paragraphs = [part.strip() for part in re.split(r"\n\s*\n", text) if part.strip() and "{download}" not in part]
    if paragraphs:
        yield "markdown", re.sub(r"\{ref\}(`[^`]+`)", r"\1", "\n\n".join(paragraphs))


def graph(text: str, known: dict[str, dict[str, str]]) -> str:
    """Write the cell that saves a graph; tables of a block `# in NAME.toml` are added to it, or replaced."""
    first = GRAPH.match(text)
    assert first, "a block of TOML begins with the name of its file"
    tables = {part.partition("]")[0]: part.strip() for part in TABLE.split(text)}
    kept = known.get(first[2], {}) if first[1] else {}
    known[first[2]] = kept | {head: part for head, part in tables.items() if head.startswith("[") or not first[1]}
    return f"%%writefile {first[2]}\n" + "\n\n".join(known[first[2]].values())


def python(text: str) -> str:
    """Write the cell of Python, or that saves a node."""
    found = NODE.search(text)
    return (f"%%writefile nodes/{found[1]}.py\n" if found else "") + text.rstrip()


def cell(kind: str, text: str, place: int) -> dict[str, object]:
    """Build a cell of a notebook."""
    lines = text.splitlines(keepends=True)
    made = {"cell_type": kind, "id": f"cell-{place}", "metadata": {}, "source": lines}
    return made | ({"execution_count": None, "outputs": []} if kind == "code" else {})


if __name__ == "__main__":
    written = notebook_of(TUTORIAL.read_text(encoding="utf-8"))
    TUTORIAL.with_suffix(".ipynb").write_text(written, encoding="utf-8")
