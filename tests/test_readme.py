"""What the README files say is so: commands parse, paths and anchors are there, figures name where they come from."""

import ast
import re
import shlex
import shutil
import textwrap
import tomllib
from types import SimpleNamespace

import click
import pytest

from hairpipe.cli.entry import commands
from hairpipe.graph.file.load import load_graph
from hairpipe.graph.file.registry import Registry

from .pages import FENCE, HOME, PAGES, SPAN, commands_of, data_of, name_of, prose_of, tables_of

MOST_LINES = 150
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEAD = re.compile(r"commit (?:[0-9a-f]{7}\b[^;]*; machine [^;]+|and machine as in each row); command .+")
MADE = re.compile(
    r"(?:hairpipe|nodes|graphs|tests|cache|\.ci)/[\w./*-]*|[\w.-]+(?:/[\w.*-]+)+\.(?:py|toml|md|bvh|webp)"
)
"""A code span that names a path of the repository."""


def paths_of(page):
    """List the paths that a page names, each with whether it may be relative to the page."""
    prose = prose_of(page)
    yield from ((HOME, span) for span in SPAN.findall(prose) if MADE.fullmatch(span))
    yield from ((page.parent, link.partition("#")[0]) for link in LINK.findall(prose) if "://" not in link)


def anchors_of(page):
    """List the anchors of a page, as its headings make them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


def has_figures(rows):
    """Whether a table has numbers beside its first column, and is no index of paths and links."""
    if all(LINK.search(row) or any(map(MADE.fullmatch, SPAN.findall(row))) for row in rows):
        return False
    return any(re.search(r"\d", SPAN.sub("", cell)) for row in rows for cell in row.strip("|").split("|")[1:])


def parse(words):
    """Parse a command as the command line would, without running it; None where it is only named."""
    command = commands
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        name, *words = words
        command = command.get_command(click.Context(command), name)
        assert command, f"no command '{name}'"
    words = [word for word in words if word != "--help"]
    return command.make_context(command.name, words) if words else None


def graph_of(given):
    """Find a graph by its path, or by the name of one that is shipped."""
    return HOME / (given if given.endswith(".toml") else f"graphs/{given}.toml")


def check_graph(params, overrides):
    """Check what a command says of a graph: its file, and the nodes and settings that it names."""
    path = graph_of(params["graph"])
    nodes = tomllib.loads(path.read_text(encoding="utf-8"))
    target = params.get("target") or SimpleNamespace(node=None, output=None)
    named = {*params.get("to", ()), *filter(None, (params.get("node"), target.node))}
    assert named <= nodes.keys()
    if not data_of(path):
        graph = load_graph(path, overrides)
        assert not target.output or target.output in graph.nodes[target.node].type.outputs


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_command_parses_and_names_what_there_is(page, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    goals = re.findall(r"^(\w+):", (HOME / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for text in commands_of(page):
        program, *words = shlex.split(text, comments=True)
        if program == "make":
            assert words[0] in goals, text
            continue
        context = parse(words)
        params = context.params if context else {}
        overrides = params.get("overrides") or {}
        if params.get("graph"):
            check_graph(params, overrides)
        for scene in params.get("scenes") or ():
            load_graph(graph_of(f"paper/{scene}"), overrides)
        if context and context.command.name == "nodes" and not params["name"].isupper():
            Registry(None).find(params["name"])


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_path_and_every_anchor_is_there(page):
    missing = [path for home, path in paths_of(page) if path and not list(home.glob(path.rstrip("/")))]
    assert not missing
    for link in LINK.findall(prose_of(page)):
        path, _, anchor = link.partition("#")
        assert not anchor or anchor in anchors_of((page.parent / path).resolve() if path else page), link


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_table_of_figures_is_headed_by_commit_machine_and_command(page):
    for before, (head, _, *rows) in tables_of(page):
        assert not has_figures(rows) or HEAD.match(" ".join(before.split())), head


def test_the_readme_is_one_page():
    assert len((HOME / "README.md").read_text(encoding="utf-8").splitlines()) <= MOST_LINES


def test_the_graph_of_the_readme_can_be_loaded(tmp_path):
    [text] = [block for language, block in FENCE.findall((HOME / "README.md").read_text()) if language == "toml"]
    folder = tmp_path / "graphs"
    shutil.copytree(HOME / "graphs/assets", folder / "assets", ignore=shutil.ignore_patterns("*.webp"))
    (folder / "shot.toml").write_text(text)
    assert load_graph(folder / "shot.toml").nodes["hair"].settings["stiction"]["release"] == 2.2e-3


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_examples_in_python_are_python(page):
    for language, block in FENCE.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            ast.parse(textwrap.dedent(block))
