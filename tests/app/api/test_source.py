"""Graphs by path, by name, as text and as tables."""

from pathlib import Path

import pytest

import hairpipe
from hairpipe.app.api import source
from hairpipe.app.api.source import find_graph, read_source
from hairpipe.errors import BadInput


@pytest.fixture
def toy(shot, monkeypatch) -> Path:
    """The shot as a shipped graph called `set/toy`."""
    monkeypatch.setattr(source, "shipped_graphs", lambda: {"set/toy": shot})
    return shot


def test_a_file_comes_before_a_name_and_a_folder_does_not_hide_one(toy):
    Path("set/toy").mkdir(parents=True)
    assert find_graph("set/toy") == toy
    Path("set/toy").rmdir()
    Path("set/toy").write_text("schema = 1")
    assert find_graph("set/toy") == Path("set/toy")
    with pytest.raises(BadInput, match=r"no graph 'set/tyo' \(.*did you mean 'set/toy'"):
        find_graph("set/tyo")


def test_where_files_are_published(toy, tmp_path):
    by_path = hairpipe.load("shot.toml").nodes
    assert by_path["list"].publish == tmp_path / "out" / "list.txt"
    by_name = hairpipe.load("set/toy").nodes
    assert by_name["list"].publish == tmp_path / "graphs" / "set" / "out" / "list.txt"
    assert by_name["seed"].publish is None
    with pytest.raises(BadInput, match="no such file"):
        hairpipe.load(Path("set/toy"))


def test_a_text_and_tables_count_as_lying_in_a_folder(shot, tmp_path, monkeypatch):
    text = shot.read_text()
    monkeypatch.chdir(tmp_path.parent)
    for graph in (text, read_source(shot).tables):
        loaded = hairpipe.load(graph, folder=tmp_path)
        assert loaded.nodes["list"].publish == tmp_path / "out" / "list.txt"
        assert loaded.nodes["sum"].type.name == "add_up"
    with pytest.raises(BadInput, match="does not apply to a graph that has a file"):
        hairpipe.load(shot, folder=tmp_path)


def test_a_fault_in_a_text_names_its_line(shot):
    with pytest.raises(BadInput, match=r"<text>:9: \[move\] move_seed: in.seed: no node 'sed'"):
        hairpipe.load(shot.read_text().replace('in.seed = "seed"', 'in.seed = "sed"'))


def test_values_of_python_become_values_of_toml():
    np = pytest.importorskip("numpy")
    given = {"a": (1, np.float32(0.5)), "b": {"c": Path("x.bvh"), "d": np.arange(2)}}
    assert source.plain(given) == {"a": [1, 0.5], "b": {"c": "x.bvh", "d": [0, 1]}}
