"""Every command and every bench that a page names starts as a process, on a graph of toys or in a small size."""

import http.client
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import click
import pytest

from hairpipe.app.cli.entry import commands

from .app.page.conftest import write_shot
from .pages import PAGES, command_of, commands_of

WEDGE = '\n[wedge.feel]\naxes = { "hair.wave.height" = [0.03, 0.05] }\nshow = ["picture"]\n'
STAGE = '#usda 1.0\n(\n    defaultPrim = "shot"\n    metersPerUnit = 1\n    upAxis = "Y"\n)\ndef Xform "shot"\n{\n}\n'
MAIN = "from hairpipe.cli import main; main()"
BENCHES = "import runpy; runpy.run_module('hairpipe.graphs.experiments.bench', run_name='__main__')"
STARTED = {
    "run": "run shot.toml -j1 -q",
    "plan": "plan shot.toml --set hair.wave.height=0.01",
    "watch": "watch shot.toml --wedge feel",
    "report": "report shot.toml -o report",
    "explain": "explain shot.toml hair@2",
    "get": "get shot.toml reach@2 -o reach.csv",
    "nodes": "nodes simulate_hair",
    "trust": "trust nodes",
    "data check": "data check --json",
    "farm": "farm shot.toml -o job",
    "results": "results .",
    "usd check": "usd check stage.usda --json",
    "bridge": "bridge",
    "blender": "blender stage.usda",
    "convert": "convert stage.usda made.usd",
    "cache du": "cache du",
    "cache ls": "cache ls",
    "cache verify": "cache verify",
    "cache doctor": "cache doctor",
    "cache gc": "cache gc shot.toml --dry-run",
    "wedge list": "wedge list shot.toml",
    "wedge table": "wedge table shot.toml feel",
    "wedge sheet": "wedge sheet shot.toml feel -o sheet.png",
    "wedge promote": "wedge promote copy.toml feel height=0.05",
    "tune": "tune shot.toml --node lag --tolerance 2mm",
    "warm": "warm shot.toml -j1 -q",
    "version": "version",
    "graph": "graph shot.toml",
    "validate": "validate shot.toml -q -j1",
    "experiments core": "core",
    "experiments swing": "swing --peers hairpipe",
    "experiments volume": "volume",
    "experiments levelset": "levelset",
    "experiments picture": "picture",
    "experiments redraw": "redraw",
    "experiments particles": "particles",
    "experiments page-frame": "page-frame shot.toml",
    "experiments faults": "faults",
    "experiments machines": "machines",
    "experiments parity": "parity",
    "experiments calls": "calls --every 500",
    "experiments schedules": "schedules --seeds 2",
    "experiments mutate": "mutate --room key --most 1",
    "experiments contact": "contact --segments 100 --between pairs",
    "bench busy": "bench busy --hairs 20 --busy 1",
    "bench digests": "bench digests --threads 1",
    "bench paper": "bench paper medium_straight --set groom.strands=24",
    "bench engine": "bench engine -j1",
    "bench first-frame": "bench first-frame shot.toml",
    "bench traffic": "bench traffic shot.toml",
    "experiments promises": "promises --scenes 1",
    "experiments needs": "needs tune/short_slow --tolerance 3%",
}
"""The words of each command."""
UNTUNABLE = "def tune(*_): raise it.Untunable('small')\nit.tune = tune"
SMALL = {
    "tune": """from hairpipe.app.tune import study, tuning
def tune(*_): raise study.Interrupted
tuning.tune = tune""",
    "convert": """from hairpipe.blender import programs as it
it.IMPORTERS = {".usda": ()}
it.run_program = lambda program, job, made, where: made[0].write_text("made")""",
    "experiments core": """from hairpipe.graphs.experiments.bench import core as it
it.MODELS = ("network",)
it.measure_core.__defaults__ = 4, 9, 17, 1 << 12, 0.0""",
    "experiments volume": """from hairpipe.graphs.experiments.bench import volume as it
it.measure_volume.__defaults__ = 200, 6, 2, 0.0""",
    "experiments levelset": """from hairpipe.graphs.experiments.bench import level_sets as it
it.measure_level_sets.__defaults__ = (0.02,), 20, True""",
    "experiments picture": """from hairpipe.graphs.experiments.bench.pictures import picture as it
it.measure_luminance = lambda *_: []
it.measure_picture.__defaults__ = ((60, 6), (30, 9)), 2""",
    "experiments redraw": """from hairpipe.graphs.experiments.bench.pictures import redraw as it
it.measure_redraw = lambda *_: it.make_report("redraw", {"redraw": [{"strands": 1}]})""",
    "experiments page-frame": """from hairpipe.graphs.experiments.bench.pictures import page_frame as it
it.measure_page_frame = lambda *_: it.make_report("page_frame", {"page": [{"part": "edit"}]})""",
    "experiments particles": """from hairpipe.graphs.experiments.bench import particles as it
it.measure_particles.__defaults__ = (150,), (1, 2), 0, 1""",
    "experiments machines": """from hairpipe.graphs.experiments.bench.machines import trials as it
it.try_machines = lambda *_: it.make_report("machines", {"faults": [{"fault": "none", "violation": ""}]})""",
    "experiments parity": """from hairpipe.graphs.experiments.bench.machines import parity as it
it.compare_ways = lambda *_: it.make_report("parity", {"ways": [{"way": "a run", "violation": ""}]})""",
    "experiments mutate": """from hairpipe.graphs.experiments.bench.mutation import mutation_trials as it
it.try_mutations = lambda *_: it.make_report("mutate", {"scores": [{"room": "key"}]})""",
    "experiments contact": """from hairpipe.graphs.experiments.bench import contact as it
it.measure_contact = lambda say, *words: it.make_report("contact", {"frames": [{"frame [s]": 0.1}]})""",
    "experiments swing": """from hairpipe.graphs.experiments.bench import swing as it
it.measure_swing = lambda *_: it.make_report("swing", {"peers": [{"name": "hairpipe"}], "converged": []})""",
    "bench busy": """from hairpipe.graphs.experiments.bench import busy as it
it.measure_busy.__defaults__ = (20,), (1,), 0, 1""",
    "bench digests": """from hairpipe.graphs.experiments.bench import digests as it
it.SCENES = {"torus": it.Scene("experiments/torus", "0-1", ("edges",), {})}""",
    "bench paper": """from hairpipe.graphs.experiments.bench import paper as it
case = {"first frame": 6, "threads": 1, "frame [s]": 0.1}
it.measure_scene = lambda *words: [(case, {"strands": 0.1})]""",
    "bench first-frame": """from hairpipe.graphs.experiments.bench.engine import first_frame as it
it.measure_first_frame = lambda *_: it.make_report("first_frame", {"phases": [{"phase": "start"}]})""",
    "bench engine": """from hairpipe.graphs.experiments.bench.engine import engine as it
short, long = (it.ToyRun(count, 0, 1.0, 1.0, None) for count in (3, 5))
it.cold_runs, it.warm_runs = lambda *_: (short, long), lambda *_: [short]""",
    "bench traffic": """from hairpipe.graphs.experiments.bench.engine import traffic as it
it.measure_scan = lambda *_: {"written [MB]": 0.1}""",
    "experiments promises": f"from hairpipe.graphs.experiments.scenes import promises as it\n{UNTUNABLE}",
    "experiments needs": f"from hairpipe.graphs.experiments.scenes import needs as it\n{UNTUNABLE}",
    "experiments faults": """from hairpipe.graphs.experiments.bench import faults as it
it.try_faults.__defaults__ = it.Trials(kills=0, damages=1, cleanings=0, modules=()),""",
}
"""Lines of Python that are carried out before, which make a command small: users have no option for it."""
SHARED = """from hairpipe.engine.worker import machine_code
machine_code.share_kernels = machine_code.guard_kernels
machine_code.guard_kernels()
"""
"""The same for all benches, before those lines import kernels: they take the table of kernels of the tests."""
EXITS = {"tune": 130, "data check": 1, "validate": 2}
"""Exit codes: tuning is interrupted before it measures, the data folder is empty, and the graph has no rows."""


def leaf_of(text: str) -> str | None:
    """Give the words of a command without its arguments; None where only a group is named."""
    command, words = command_of(text)
    path = [] if command is commands else ["experiments"]
    while isinstance(command, click.Group) and words:
        path.append(words.pop(0))
        command = command.get_command(click.Context(command), path[-1])
    return None if isinstance(command, click.Group) else " ".join(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a graph of toys that was run, a copy of it, and a USD file."""
    folder = tmp_path_factory.mktemp("entry")
    shot = write_shot(folder)
    shot.write_text(shot.read_text() + WEDGE)
    (folder / "copy.toml").write_text(shot.read_text())
    (folder / "stage.usda").write_text(STAGE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HAIRPIPE_TRUST", str(folder / "nodes"))
        patch.setenv("HAIRPIPE_CACHE", str(folder / "cache"))
        patch.setenv("HAIRPIPE_DATA", str(folder / "data"))
        start(folder, "run shot.toml --wedge feel -j1 -q")
        yield folder


def start(folder: Path, words: str, before: str = "", code: int = 0, main: str = MAIN) -> tuple[str, str]:
    """Carry a command out in a process of its own, and give what it wrote to both streams."""
    command = [sys.executable, "-c", f"{before}\n{main}", *words.split()]
    variables = os.environ | {"NUMBA_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True)
    assert done.returncode == code and "Traceback" not in done.stderr, done.stderr
    return done.stdout, done.stderr


def test_every_command_that_a_page_names_is_started():
    named = {leaf_of(text) for page in PAGES for text in commands_of(page) if not text.startswith("make ")}
    assert named - {None} <= STARTED.keys() | {"view"}


COMPILING = ("bench", "experiments")
MARKED = [pytest.param(path, marks=[pytest.mark.kernels] * path.startswith(COMPILING)) for path in STARTED]


@pytest.mark.parametrize("path", MARKED)
def test_it_starts_and_ends_well(path, folder):
    before = SHARED * path.startswith(COMPILING) + SMALL.get(path, "")
    main = BENCHES if path.startswith("experiments") else MAIN
    written = start(folder, STARTED[path], before, EXITS.get(path, 0), main)
    assert any(written) or "-q" in STARTED[path]


@pytest.mark.parametrize("wedge", ["", "--wedge feel"])
def test_view_serves_its_page_until_it_is_interrupted(wedge, folder):
    command = [sys.executable, "-c", MAIN, "view", "shot.toml", "--no-browser", *wedge.split()]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        place = urlsplit(process.stdout.readline().split()[0])
        connection = http.client.HTTPConnection(str(place.hostname), place.port, timeout=20)
        connection.request("GET", f"{place.path}data/graph.js")
        assert connection.getresponse().status == 200
        connection.close()
        process.send_signal(signal.SIGINT)
        process.wait(20)
