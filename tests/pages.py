"""Reads pages: their prose, tables and commands; and the data that graphs name."""

import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from hairpipe.app.cli.entry import commands
from hairpipe.graphs.experiments.bench.commands import bench

HOME = Path(__file__).resolve().parents[1]
ROOMS = ("", "cache", "graphs", "hairpipe", "nodes", "tests")
DOCS = sorted((HOME / "docs").rglob("*.md"))
PAGES = [
    HOME / "CONTRIBUTING.md",
    HOME / "SECURITY.md",
    *sorted(page for room in ROOMS for page in (HOME / room).glob("**/README.md" if room else "README.md")),
    *DOCS,
]
BENCHES = "python -m hairpipe.graphs.experiments.bench "
PROGRAMS = ("hairpipe ", "make ", BENCHES)
"""What begins a command that the tests read and start."""
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"(?<!`)`([^`]+)`(?!`)")
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
INDENTED = re.compile(r"(?:^|\n\n)((?: {4}.*\n)+)")


TABLE = re.compile(r"\n(?=\[[^\].]+\])")
DECLARED = re.compile(r"^@node.*\ndef (\w+)", re.MULTILINE)


def name_of(page: Path) -> str:
    return page.relative_to(HOME).as_posix()


def prose_of(page: Path) -> str:
    """Give a page without its fenced blocks and comments."""
    return COMMENT.sub("", FENCE.sub("", page.read_text(encoding="utf-8")))


def commands_of(page: Path) -> list[str]:
    """List the commands of a page: in code spans, and in lines of indented blocks up to two blanks."""
    prose = prose_of(page)
    blocks = [line.strip() for block in INDENTED.findall(prose) for line in block.splitlines()]
    lines = [re.split(r" {2,}", line)[0] for line in blocks]
    spans = [" ".join(span.split()) for span in SPAN.findall(INDENTED.sub("\n", prose))]
    return [text for text in [*lines, *spans] if text.startswith(PROGRAMS)]


def command_of(text: str) -> tuple[click.Command, list[str]]:
    """Find the program that a command starts, and its arguments: the command line, or the benches of parts."""
    if text.startswith(BENCHES):
        return bench, shlex.split(text.removeprefix(BENCHES), comments=True)
    return commands, shlex.split(text, comments=True)[1:]


def graphs_of(page: Path) -> Iterator[tuple[str, str]]:
    """List the graph files that a page has its reader write, each time that it does: name and text.

    The block of a new file begins with `# NAME.toml`; one with `# in NAME.toml` has tables that are added or replaced.
    """
    known: dict[str, dict[str, str]] = {}
    for language, text in FENCE.findall(page.read_text(encoding="utf-8")):
        first = re.match(r"# (in )?([\w-]+\.toml)\b", text)
        if language == "toml" and first:
            tables = {part.partition("]")[0]: part.strip() for part in TABLE.split(text)}
            name, kept = first[2], known.get(first[2], {})
            known[name] = kept | {head: part for head, part in tables.items() if head.startswith("[") or not first[1]}
            yield name, "\n\n".join(known[name].values())


def nodes_of(page: Path) -> dict[str, str]:
    """Return the nodes that a page declares, by name."""
    blocks = [text for language, text in FENCE.findall(page.read_text(encoding="utf-8")) if language == "python"]
    return {found[1]: text for text in blocks if (found := DECLARED.search(text))}


def write_files(page: Path, folder: Path) -> None:
    """Write what the reader of a page has, or makes, in a folder: the shipped graphs, nodes, and the last graphs."""
    (folder / "graphs").symlink_to(HOME / "graphs")
    (folder / "nodes").mkdir()
    for name, text in nodes_of(page).items():
        (folder / f"nodes/{name}.py").write_text(text)
    for name, text in graphs_of(page):
        (folder / name).write_text(text)


def tables_of(page: Path) -> Iterator[tuple[str, list[str]]]:
    """List the tables of a page: the paragraph before each, its rows without the head, and its first line."""
    paragraphs = prose_of(page).split("\n\n")
    for before, paragraph in zip(["", *paragraphs], paragraphs, strict=False):
        if paragraph.lstrip("\n").startswith("|"):
            yield before, paragraph.strip().splitlines()


def data_of(graph: Path) -> set[str]:
    """Name the third-party files that a graph file reads."""

    def named(value: Any) -> Iterator[str]:
        if isinstance(value, dict):
            if value.keys() == {"data"} and isinstance(value["data"], str):
                yield value["data"]
            for inner in value.values():
                yield from named(inner)

    return set(named(tomllib.loads(graph.read_text(encoding="utf-8"))))
