"""Where a graph may publish: within its project, and over nothing that is not hairpipe's."""

import os
from pathlib import Path

import pytest

from hairpipe.engine.file.graph import project_of
from hairpipe.engine.run import publish
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store import atomic
from hairpipe.errors import BadInput

from ..conftest import CHAIN

pytestmark = pytest.mark.usefixtures("kept")

MINE = "mine\n"


@pytest.fixture
def outside(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("outside")


def publish_to(shot, path) -> None:
    shot.write(CHAIN.replace('"out/list.txt"', f'"{path}"'))


def refused(shot, **how) -> str:
    """Run what must be refused before anything is evaluated."""
    with pytest.raises(BadInput) as caught:
        shot.run(**how)
    assert not shot.tally()
    return str(caught.value)


def test_a_project_is_the_folder_that_contains_graphs(tmp_path, monkeypatch):
    for name in ("graphs/a.toml", "graphs/paper/b.toml"):
        assert project_of(tmp_path / name) == tmp_path
    assert project_of(tmp_path / "shots" / "c.toml") == tmp_path / "shots"
    monkeypatch.setenv("HOME", str(tmp_path))
    assert project_of(tmp_path / "graphs" / "a.toml") == tmp_path / "graphs", "a home folder is nobody's project"


@pytest.mark.parametrize("path", ["../list.txt", "../../home/.hidden.txt", "{outside}/list.txt", "out/../../list.txt"])
def test_a_path_outside_is_refused_before_the_run(shot, outside, path):
    publish_to(shot, path.format(outside=outside))
    assert f"the path leaves {shot.folder} (a path within, or --publish-root FOLDER)" in refused(shot)
    assert not list(outside.iterdir())


@pytest.mark.parametrize("way", ["out", "out/deep", "out/list.txt"])
def test_links_that_lead_out_are_refused(shot, outside, way):
    publish_to(shot, "out/deep/list.txt" if way == "out/deep" else "out/list.txt")
    link = shot.folder / way
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(outside / "list.txt" if way.endswith("txt") else outside)
    assert "the path leaves" in refused(shot)
    assert not list(outside.iterdir())


def test_a_folder_that_the_user_names_is_within(shot, outside):
    publish_to(shot, outside / "deep" / "list.txt")
    assert not shot.run(root=outside).failures
    assert (outside / "deep" / "list.txt").is_file()


@pytest.mark.parametrize("swapped", ["out", "out/parts"])
def test_a_link_that_comes_later_is_not_followed(shot, outside, swapped):
    """Between the check and the copy a folder becomes a link to another one."""
    graph = shot.load(list__parts="true")
    link = shot.folder / swapped
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(outside)
    (failure,) = run(graph, shot.store).failures
    assert failure.kind == "publish" and "the path contains a link" in failure.message
    assert not list(outside.iterdir())


def test_a_folder_that_becomes_a_link_while_it_is_entered_is_not_followed(shot, outside, monkeypatch):
    monkeypatch.setattr(publish, "check_way", lambda place: None)  # it was none when it was looked at
    graph = shot.load()
    (shot.folder / "out").symlink_to(outside)
    (failure,) = run(graph, shot.store).failures
    assert failure.kind == "publish" and not list(outside.iterdir())


def test_predicted_temporary_names_are_not_written(shot, outside, monkeypatch):
    """A temporary name with a link behind it: the link is not followed, and nothing is published."""
    (shot.folder / "out").mkdir()
    (shot.folder / "out" / ".hairpipe-foreseen.tmp").symlink_to(outside / "victim")
    shot.run()  # all but the file is there: nothing else needs a name
    (shot.folder / "out" / "list.txt").unlink()
    monkeypatch.setattr(atomic, "make_name", lambda: "foreseen")
    (failure,) = shot.run().failures
    assert failure.kind == "publish" and "File exists" in failure.message
    assert not (outside / "victim").exists() and not (shot.folder / "out" / "list.txt").exists()


@pytest.mark.parametrize(
    ("path", "what"),
    [
        ("lib/nodes/hat.txt", "the path is in a folder of node types"),
        ("lib/NODES/hat.txt", "the path is in a folder of node types"),
        (".git/list.txt", "the path is hidden"),
        ("out/--checkpoint-action=exec.txt", "the path is a name that looks like an option of a command"),
        ("out/list\u202egnp.txt", "the path is a name with invisible characters"),
        ("out/a\\u001bb.txt", "the path is a name with invisible characters"),
        ("cache/actions/list.txt", "the path is in the store"),
        ("lib/Site-Packages/list.txt", "the path is in the packages of Python"),
        ("dist-packages/a/list.txt", "the path is in the packages of Python"),
    ],
)
def test_some_paths_are_never_published_to(shot, path, what):
    publish_to(shot, path)
    place = shot.folder / path.replace("\\u001b", "\x1b")
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(MINE)
    assert what in refused(shot, force=True)
    assert place.read_text() == MINE


@pytest.mark.parametrize("mark", ["pyvenv.cfg", "conda-meta"])
def test_an_environment_of_python_is_not_written_to(shot, tmp_path_factory, mark):
    """Neither by its path, nor by a link, nor where the user allows a folder within."""
    environment = tmp_path_factory.mktemp("env")
    (environment / mark).touch()
    publish_to(shot, "link/lib/list.txt")
    (shot.folder / "link").symlink_to(environment)
    assert "the path is in an environment of Python" in refused(shot, root=environment, force=True)
    assert "the path is in an environment of Python" in refused(shot, root=environment / "lib", force=True)
    assert [path.name for path in environment.iterdir()] == [mark]


def test_a_file_is_published_only_under_suffixes_that_its_node_writes(shot):
    for suffix in ("pth", "so", "sh", "py", "pyc", "toml", "json", "yaml", "mk", "html", "md", "d"):
        for stem in ("out/list.", "out/list.txt."):
            publish_to(shot, stem + suffix)
            assert f"write_list does not write '.{suffix}' files (a name that ends in .txt)" in refused(shot)
    for name in ("Makefile", "out/package", ".pth", ".txt", "list.txt.", "list.txt "):
        publish_to(shot, name)
        assert "write_list does not write '" in refused(shot), name


def test_companions_have_suffixes_of_data(shot):
    shot.edit("write_list.py", "parts/sums.txt", "parts/aa.pth")
    (failure,) = shot.run(list__parts="true").failures
    assert failure.kind == "publish" and "'.pth' is not a suffix of data" in failure.message
    assert not list(shot.folder.rglob("*.pth"))


def test_a_file_of_the_user_is_kept_without_force(shot):
    path = shot.folder / "out" / "list.txt"
    path.parent.mkdir()
    path.write_text(MINE)
    events = []
    (failure,) = shot.run(report=events.append).failures
    assert [event.kind for event in events[:2]] == ["begun", "warning"], "before it is computed"
    ((name, message),) = shot.warned
    assert name == "list" and "is kept unless" in message
    assert "a file exists that is not from hairpipe, or was changed since" in failure.message
    assert "--force" in failure.message and path.read_text() == MINE
    outcome = shot.run(force=True)
    assert not outcome.failures and outcome.evaluated == 0 and path.read_text() != MINE


def test_a_pipe_in_the_way_is_refused(shot):
    (shot.folder / "out").mkdir()
    os.mkfifo(shot.folder / "out" / "list.txt")
    (failure,) = shot.run(force=True).failures
    assert failure.kind == "publish" and "the existing path is not a file" in failure.message
