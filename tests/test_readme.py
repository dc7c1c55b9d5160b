"""What the README files say is so: commands parse, paths and anchors are there, no figure is typed."""

import os
import re
import sys
import tomllib
from pathlib import Path
from types import ModuleType, SimpleNamespace

import click
import numpy as np
import pytest

import hairpipe
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.file.registry import Registry
from hairpipe.graphs.experiments.figures.pages import DIRECTIVE, figure_of, find_results

from .pages import (
    COMMENT,
    DECLARED,
    FENCE,
    HOME,
    PAGES,
    SPAN,
    command_of,
    commands_of,
    data_of,
    name_of,
    prose_of,
    write_files,
)

MOST_LINES = 90
INCLUDE = re.compile(r"^:::\{include\} (\S+)$", re.MULTILINE)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEAD = re.compile(r"commit [0-9a-f]{7}\b[^;]*; machine [^;]+")
NUMBER = re.compile(r"[\s*~<>+-]*\.?\d")
TEST = re.compile(r"`(?:[\w.-]+/)*test_\w+\.py`")
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
    """List the anchors of a page, and of those that it includes, as their headings make them."""
    text = page.read_text(encoding="utf-8")
    inner = [anchors_of((page.parent / path).resolve()) for path in INCLUDE.findall(text)]
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return set().union(*inner) | {
        re.sub(r"[^\w -]", "", heading).strip().lower().replace(" ", "-") for heading in headings
    }


def typed_figures(text):
    """List what a page has typed in place of a reference to a record; pure.

    These are heads of measured tables, and rows outside of the directive `results` in which a cell begins with a
    number. Settings are code spans; the row of a bound names the test that holds it.
    """
    text = DIRECTIVE.sub("", COMMENT.sub("", FENCE.sub("", text)))
    rows = [line for line in text.splitlines() if line.startswith("|")]
    measured = [row for row in rows if any(map(NUMBER.match, row.split("|"))) and not TEST.search(row)]
    return HEAD.findall(text) + measured


def parse(text):
    """Parse a command as the command line would, without running it; None where it is only named."""
    command, words = command_of(text)
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        name, *words = words
        command = command.get_command(click.Context(command), name)
        assert command, f"no command '{name}'"
    words = [word for word in words if word != "--help"]
    return command.make_context(command.name, words) if words else None


def graph_of(given):
    """Find a graph by its path, or by the name of one that is shipped; a page may have its reader write it."""
    if Path(given).is_file():
        return Path(given).resolve()
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
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    monkeypatch.setattr(
        "hairpipe.graphs.experiments.figures.bench_recording.commit_of", lambda folder: "0" * 40
    )  # nothing is recorded
    write_files(page, tmp_path)
    (tmp_path / "head.usd").touch()  # which a tutorial makes
    goals = re.findall(r"^(\w+):", (HOME / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for text in commands_of(page):
        if text.startswith("make "):
            assert text.split()[1] in goals, text
            continue
        context = parse(text)
        params = context.params if context else {}
        overrides = params.get("overrides") or {}
        if params.get("graph"):
            check_graph(params, overrides)
        for scene in params.get("scenes") or ():
            load_graph(graph_of(f"paper/{scene}"), overrides)
        if context and context.command.name == "nodes" and not params["name"].isupper():
            Registry(tmp_path / "nodes" if params["graph"] else None).find(params["name"])


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_path_and_every_anchor_is_there(page):
    missing = [path for home, path in paths_of(page) if path and not list(home.glob(path.rstrip("/")))]
    assert not missing
    for link in LINK.findall(prose_of(page)):
        path, _, anchor = link.partition("#")
        assert not anchor or anchor in anchors_of((page.parent / path).resolve() if path else page), link


@pytest.mark.parametrize("page", [*PAGES, HOME / "CHANGELOG.md"], ids=name_of)
def test_no_figure_is_typed_in_a_page(page):
    assert not typed_figures(page.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "text",
    [
        "commit 76f0664; machine two cores of an Intel Xeon; command `make demo`",
        "| error | 1.3 % |",
        "| one |  -.5 |",
        "| **0.4** |",
        "| ~ 2 s |",
        "| < 3 |",
    ],
)
def test_typed_figures_are_found(text):
    assert typed_figures(f"A sentence of 3 words.\n\n{text}\n")


@pytest.mark.parametrize(
    "text",
    [
        ":::{results} circle\n| one | 1.3 |\n:::",
        "| error | 1.3 % | `tests/test_readme.py` |",
        "| `1.5` | a setting |",
        "| hair of 30 cm | chain |",
        "```toml\n| 1 | 2 |\n```",
    ],
)
def test_references_settings_and_bounds_are_not_typed_figures(text):
    assert not typed_figures(f"{text}\n")


README = HOME / "README.md"
VIBRATION = "vibration_table; lower error [%]; case=rod; segments=25; largest; #.2g"
BETWEEN = "analytic_table; error max [%]; interpolation=parts; max; .2g"
CANTILEVER = "cantilever_table; tip error [% of length]; case=rod; segments=25; from hanging [deg]=90; largest; #.2g"
FIGURES = [
    ("within {} % of its length", "experiments/accuracy", CANTILEVER),
    (
        "frequencies within {} %",
        "experiments/accuracy",
        "vibration_table; lower error [%]; case=rod; segments=25; largest; #.2g",
    ),
    ("hairs is Coulomb's within {} %", "experiments/validate_rub", "rows; measured; unit=%; max; #.2g"),
    (
        "body is within {} % of",
        "experiments/interpolation",
        "analytic_table; error max [%]; interpolation=parts; max; .2g",
    ),
    ("take {} s a frame", "paper/paper", "frames; frame [s]; scene=long_straight_10000; first frame=6; #.2g"),
    ("take {} s.", "paper/hundred_thousand", "frames; frame [s]; scene=hundred_thousand_volume; .0f"),
]
"""Figures of the README, and the records that they are from."""


@pytest.mark.parametrize(("words", "name", "reference"), FIGURES)
def test_figures_of_the_readme_are_those_of_the_records(words, name, reference):
    text = " ".join(README.read_text(encoding="utf-8").split())
    assert words.format(figure_of(name, f"{{{reference}}}", lambda path: "")) in text


def test_every_results_file_is_shown_on_a_page():
    shown = {path.resolve() for path in find_results(PAGES)}
    assert {path.resolve() for path in find_results([HOME / "graphs", HOME / "hairpipe"])} == shown


@pytest.mark.parametrize("path", find_results([HOME / "graphs", HOME / "docs"]), ids=lambda path: path.stem)
def test_results_contain_no_path_of_a_machine(path):
    """In commands, paths are relative."""
    assert not re.findall(r"""(?:^|[\s'"=(])/\w[\w.-]*/[\w./-]+""", path.read_text(encoding="utf-8"))


def test_the_readme_is_one_page():
    assert len(README.read_text(encoding="utf-8").splitlines()) <= MOST_LINES


GROWING = re.compile(r"# (in )?[\w-]+\.toml\b")
"""What begins a block of a graph that a page has its reader write: `tests/test_docs.py` loads these as they grow."""
STAND_INS = """
[parts]
type = "bake_parts"
in = { rest = "head", pose = "motion" }
[front]
type = "grow_groom"
in.scalp = "head"
[back]
like = "front"
[watch]
type = "watch_hair"
in = { hair = "hair", groom = "groom" }
[motion_of_hair]
type = "measure_motion"
in.hair = "hair"
"""
"""Nodes that examples refer to besides those of the demo."""


def with_tables(tables, more):
    """Return tables in which others are merged; a node that states its type replaces one of its name."""
    merged = dict(tables)
    for name, value in more.items():
        known = merged.get(name)
        merge = isinstance(known, dict) and isinstance(value, dict) and "type" not in value
        merged[name] = with_tables(known, value) if merge else value
    return merged


def needed_by(own, tables):
    """Return what tables have for the whole graph, and those nodes that some of them need; pure."""
    names = {name for name, value in tables.items() if not isinstance(value, dict) or name == "wedge"}
    queue = [
        "hair",
        *own,
        *(name for wedge in own.get("wedge", {}).values() for name in (*wedge["axes"], "watch", "picture")),
    ]
    while queue:
        name = queue.pop()
        if name in tables and name not in names:
            names.add(name)
            sockets = tables[name].get("in", {}).values()
            queue += [each for socket in sockets for each in (socket if isinstance(socket, list) else [socket])]
            queue += [tables[name].get("like", "")]
    return {name: tables[name] for name in tables if name in names}


@pytest.mark.parametrize(
    ("page", "block"),
    [
        pytest.param(page, block, id=f"{name_of(page)}-{number}")
        for page in PAGES
        for number, (language, block) in enumerate(FENCE.findall(page.read_text(encoding="utf-8")))
        if language == "toml" and not GROWING.match(block)
    ],
)
def test_tables_of_pages_are_accepted(page, block, tmp_path, monkeypatch):
    """A block with frames, head and body is a graph; any other is merged into the demo, whose nodes it refers to."""
    write_files(page, tmp_path)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "assets").symlink_to(HOME / "graphs/assets")
    (tmp_path / "character.usd").touch()
    own = tables = tomllib.loads(block)
    if not {"frames", "head", "body"} <= own.keys():
        demo = tomllib.loads((HOME / "graphs/demo.toml").read_text(encoding="utf-8") + STAND_INS)
        tables = needed_by(own, with_tables(demo, own))
    shot = hairpipe.load(tables)
    for wedge in tables.get("wedge", {}):
        assert shot.wedge(wedge)
    assert shot.nodes


def write_surroundings(folder):
    """Write what the examples in Python name: a graph, and the package of somebody's studio."""
    hair = '[hair]\ntype = "simulate_hair"\nmodel = "chain"\nin.groom = "groom"\n'
    groom = '[groom]\ntype = "make_strands"\nlength = 0.1\nsegments = 5\n'
    (folder / "demo").write_text(f"schema = 1\nframes = [1001, 1060]\nfps = 24\n{groom}{hair}")
    (folder / "nodes/my_studio").mkdir(parents=True)
    (folder / "nodes/my_studio/grooming.py").write_text("def trim(groom, length):\n    return groom\n")


@pytest.mark.parametrize(
    ("page", "block"),
    [
        pytest.param(page, block, id=f"{name_of(page)}-{number}")
        for page in PAGES
        for number, (language, block) in enumerate(FENCE.findall(page.read_text(encoding="utf-8")))
        if language == "python" and "import bpy" not in block  # which is a script for Blender
    ],
)
def test_examples_in_python_run_as_they_stand(page, block, tmp_path, monkeypatch, capsys):
    """A node is written into a file of its name, and run in a graph; everything else is run as a script."""
    write_surroundings(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    code, declared = compile(block, str(page), "exec"), DECLARED.search(block)
    if declared:
        (tmp_path / f"nodes/{declared[1]}.py").write_text(f'"""An example."""\n{block}')
        own = f'[own]\ntype = "{declared[1]}"\nin.groom = "groom"\n'
        shot = hairpipe.load((tmp_path / "demo").read_text() + own)
        assert shot.run(to="own", jobs=1).ok and len(repr(shot.get("own"))) > 0
        return
    names = {"__name__": "example"}
    sys.modules["example"] = ModuleType("example")
    exec(code, names)
    strands = names.get("strands")
    assert np.isfinite(strands.points).all() if strands else capsys.readouterr().out
