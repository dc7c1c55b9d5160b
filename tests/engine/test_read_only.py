"""A store that can be read and not written to: what is there is used, what is not is refused before it is computed."""

import errno
import os
import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

from hairpipe.engine.run.events import Judge
from hairpipe.engine.run.survey import Survey
from hairpipe.engine.store import atomic


@pytest.fixture
def read_only(shot, monkeypatch):
    """The shot after a run, nothing of whose store can be changed any more; root may write to any folder."""
    assert shot.run(list__parts="true").exit_code == 0
    shutil.rmtree(shot.folder / "out")
    shot.tally()
    root, making = shot.store.root, atomic.making

    def is_inside(path):
        return not isinstance(path, int) and Path(path).is_relative_to(root)

    @contextmanager
    def refusing(folder):
        if is_inside(folder):
            raise OSError(errno.EROFS, "Read-only file system", str(folder))
        with making(folder) as made:
            yield made

    def guarded(function):
        def refuse(path, *given, **named):
            if is_inside(path):
                raise OSError(errno.EROFS, "Read-only file system", str(path))
            return function(path, *given, **named)

        return refuse

    monkeypatch.setattr(atomic, "making", refusing)
    for name in ("utime", "unlink", "mkdir", "rmdir", "chmod", "link"):
        monkeypatch.setattr(os, name, guarded(getattr(os, name)))
    access = os.access
    monkeypatch.setattr(
        os, "access", lambda path, mode: not (is_inside(path) and mode & os.W_OK) and access(path, mode)
    )
    return shot


def test_a_run_whose_results_are_all_there_works_and_publishes(read_only):
    before = sorted((path, path.stat().st_mtime_ns) for path in read_only.store.root.rglob("*"))
    outcome = read_only.run(list__parts="true")
    assert outcome.exit_code == 0 and outcome.cached == 22 and read_only.tally() == {}
    assert sorted(path.name for path in (read_only.folder / "out").rglob("*.txt")) == ["list.txt", "sums.txt"]
    assert sorted((path, path.stat().st_mtime_ns) for path in read_only.store.root.rglob("*")) == before


def test_a_survey_of_it_changes_nothing(read_only):
    before = sorted((path, path.stat().st_mtime_ns) for path in read_only.store.root.rglob("*"))
    assert Survey(read_only.load(list__parts="true"), read_only.store, None, Judge()).complete
    survey = Survey(read_only.load(seed__value="7"), read_only.store, None, Judge())
    assert survey.nodes["seed"].missing == 1 and survey.nodes["sum"].waiting == 10
    assert sorted((path, path.stat().st_mtime_ns) for path in read_only.store.root.rglob("*")) == before
