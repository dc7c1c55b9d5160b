"""A repository with a graph that measures something, its results, and a page."""

import subprocess
import sys
from pathlib import Path

import pytest

from hairpipe.engine.worker import machine_code
from hairpipe.graphs.experiments.figures import pages
from hairpipe.graphs.experiments.figures.file import read_results

from ...app.cli.conftest import hairpipe  # noqa: F401

GRAPH = """schema = 1
frames = [1, 2]
fps = 24
[circle]
type = "measure_circle"
sides = [6, 12]
[table]
type = "write_table"
in.tables = "circle"
publish = "../out/circle.csv"
"""
NODE = '''"""Circles by polygons."""

import math

import rounding

from hairpipe.values import Table
from hairpipe.engine import node


@node(frames="once")
def measure_circle(*, sides: tuple[int, ...] = (6,)) -> Table:
    """Measure how much shorter a polygon is than its circle.

    sides  of each polygon
    """
    from hairpipe.values.table import table_of_columns

    errors = [100.0 * (count / math.pi * math.sin(math.pi / count) - 1.0) for count in sides]
    table = {"sides": sides, "error [%]": [rounding.rounded(error) for error in errors]}
    return table_of_columns(table | {"area": [math.nan for _ in sides]})
'''
ROUNDING = '''"""Rounding."""


def rounded(value):
    """Round a number."""
    return round(value, 6)
'''
PAGE = """# Circles

:::{results} circle
| sides | error |
| --- | ---: |
| {table; sides} | {table; error [%]; .2g} % |
:::

At most {results}`circle {table; error [%]; largest; .2f}` % of a circle.
"""


def git(folder: Path, *words: str) -> str:
    """Call git in a folder."""
    named = ["-c", "user.name=Test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false"]
    done = subprocess.run(["git", *named, *words], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def edit(path: Path, old: str, new: str) -> None:
    """Change a file."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository of which everything is committed; it is the current folder."""
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "graphs/nodes"))
    monkeypatch.setattr(pages, "GRAPHS", tmp_path / "graphs")
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(()))
    monkeypatch.setattr(sys, "path", list(sys.path))
    before = set(sys.modules)
    (tmp_path / "graphs/nodes").mkdir(parents=True)
    files = {"circle.toml": GRAPH, "nodes/measure_circle.py": NODE, "nodes/rounding.py": ROUNDING, "README.md": PAGE}
    for name, text in files.items():
        (tmp_path / "graphs" / name).write_text(text)
    (tmp_path / ".gitignore").write_text("cache/\nout/\n__pycache__/\n")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-q", "-m", "all of it")
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


@pytest.fixture
def recorded(repository, hairpipe) -> Path:  # noqa: F811
    """The repository after a run that has recorded its table."""
    done = hairpipe("run graphs/circle.toml -j1 -q --record")
    assert done.exit_code == 0
    assert read_results(repository / "graphs/results/circle.json").tables
    return repository
