"""Progress as lines, and as bars: drawn from the same events; the compilation of a first run is named once."""

import pytest

import hairpipe
from hairpipe.app.cli import run_display as lines
from hairpipe.app.cli.run_display import Bars, Lines, RunDisplay, cells, running_line
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import Event, NodeProgress, Progress


@pytest.fixture
def progress(shot) -> Progress:
    found = Progress(load_graph(shot), jobs=1)
    found.update(Event("begun", totals=(("seed", 1), ("move", 3))))
    return found


def feed(progress: Progress, drawing: Lines | Bars, *events: tuple[str, str, int | None]) -> None:
    for kind, node, frame in events:
        event = Event(kind, Task(node, frame), seconds=0.5)
        progress.update(event)
        drawing.update(event)


MOVING = (("cached", "seed", None), ("cached", "move", 1), ("started", "move", 2), ("finished", "move", 2))


def test_a_node_begins_once_and_is_done_once(progress, capsys):
    feed(progress, Lines(progress), *MOVING, ("started", "move", 3), ("finished", "move", 3))
    expected = ["seed: cached", "move: begins", "move: done, 2 of 3 results computed, 1 were cached"]
    assert capsys.readouterr().err.splitlines() == expected


@pytest.mark.parametrize("between", [(), (("started", "move", 3),)], ids=["between two frames", "in a frame"])
def test_progress_lines_are_written_at_intervals(progress, capsys, monkeypatch, between):
    monkeypatch.setattr(lines, "INTERVAL", -1.0)
    feed(progress, Lines(progress), *MOVING[:-1], *between, MOVING[-1])
    assert capsys.readouterr().err.splitlines()[-1] == "move: 2/3, 0.50 s each, 0.50 s left"


def test_a_bar_says_the_same_and_without_a_rate_yet_no_time_is_left():
    assert running_line(NodeProgress(total=3, width=1)) == "0/3"
    assert cells(NodeProgress(total=3, width=1))[1:] == ["0/3", "", "", ""]
    node = NodeProgress(total=10, width=1, cached=4, evaluated=2)
    node.recent.extend([1.0, 2.0, 3.0])
    assert cells(node)[1:] == ["6/10", "2.00 s/frame", "8.00 s left", "4 cached"]


def test_bars_are_drawn_for_what_is_under_way_only(progress):
    bars = Bars(progress)
    feed(progress, bars, *MOVING[:2])
    assert bars.rows.row_count == 0
    feed(progress, bars, *MOVING[2:])
    assert bars.rows.row_count == 1, "between two frames too"
    feed(progress, bars, ("started", "move", 3), ("finished", "move", 3))
    assert bars.rows.row_count == 0


GRAPH = 'schema = 1\nframes = [1, 2]\nfps = 24\n[tuft]\ntype = "make_strands"\n'


@pytest.mark.parametrize("compiled", [False, True])
def test_the_first_run_names_its_compilation_once(compiled, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    if compiled:
        (tmp_path / "hairpipe" / "module").mkdir(parents=True)
        (tmp_path / "hairpipe" / "module" / "kernel.nbc").touch()
    with RunDisplay(hairpipe.load(GRAPH).graph, 1, quiet=False) as display:
        display(Event("begun", totals=(("tuft", 1),)))
        for _ in range(2):
            display(Event("started", Task("tuft", None)))
    assert capsys.readouterr().err.count("kernels are compiled, once, in about a minute") == (not compiled)
