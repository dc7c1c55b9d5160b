"""A toy shot in the current folder, and the command line as a function."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from hairpipe.app.cli.entry import commands
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.worker import machine_code

TOYS = Path(__file__).parents[2] / "engine" / "toys"
SHOT = """schema = 1
frames = [1, 6]
fps = 24
[seed]
type = "make_seed"
value = 3
[move]
type = "move_seed"
in.seed = "seed"
[sum]
type = "add_up"
in.number = "move"
checkpoint = 3
[list]
type = "write_list"
in.numbers = "sum"
publish = "out/list.txt"
[drawing]
type = "draw_number"
in.number = "sum"
publish = "out/drawing.####.txt"
"""
FAILING = """
[bad]
type = "go_wrong"
in.number = "move"
"""

Hairpipe = Callable[..., Result]
START = [
    sys.executable,
    "-c",
    """from hairpipe.engine.worker import machine_code
machine_code.kernel_modules = lambda: iter(())
from hairpipe.cli import main
main()""",
]
"""The command line as a process; like `shot`, it does not analyse modules with kernels, which no toy calls."""


def write_shot(folder: Path) -> Path:
    """Write the graph file and its node types."""
    shutil.copytree(TOYS, folder / "nodes", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "shot.toml").write_text(SHOT)
    return folder / "shot.toml"


@pytest.fixture
def hairpipe() -> Hairpipe:
    """Call the command line with arguments in one text; what is neither an exit nor a result is raised."""

    def call(arguments: str) -> Result:
        result = CliRunner().invoke(commands, arguments.split(), prog_name="hairpipe")
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return call


@pytest.fixture
def shot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The file `shot.toml` of six frames in the current folder: seed, move, sum (a scan), a list and drawings."""
    monkeypatch.setenv("TOY_TALLY", str(tmp_path / "tally"))
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    monkeypatch.setattr(sys, "path", list(sys.path))
    # Toys call no kernel of ours: a new store would analyse all modules that hold some, at half the cost of a run.
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(()))
    before = set(sys.modules)
    path = write_shot(tmp_path)
    monkeypatch.chdir(tmp_path)
    yield path
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


@pytest.fixture(scope="session")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the shot was run once, for all tests that want to copy it."""
    folder = tmp_path_factory.mktemp("result")
    write_shot(folder)
    variables = {"TOY_TALLY": str(folder / "tally"), "HAIRPIPE_TRUST": str(folder / "nodes")}
    subprocess.run([*START, "run", "shot.toml", "-j1", "-q"], cwd=folder, env=os.environ | variables, check=True)
    return folder


@pytest.fixture
def computed(shot: Path, result: Path) -> Path:
    """The shot after a run."""
    for name in ("cache", "out"):
        shutil.copytree(result / name, name)
    (known,) = Path("cache", "latest").iterdir()
    known.rename(known.with_name(load_graph(shot).name))
    return shot


@pytest.fixture
def failing(shot: Path) -> Path:
    """The shot with a node that fails at frame 3."""
    shot.write_text(SHOT + FAILING)
    return shot
