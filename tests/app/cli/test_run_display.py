"""The display of a run names the compilation of a first run, once."""

import pytest

import hairpipe
from hairpipe.app.api.reports import Event
from hairpipe.app.cli.run_display import RunDisplay
from hairpipe.engine.plan.tasks import Task

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
