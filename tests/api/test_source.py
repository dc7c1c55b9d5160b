"""Graphs by path or by name."""

from pathlib import Path

import pytest

from hairpipe.api import source as shipped
from hairpipe.api.source import find_graph, open_graph, shipped_graphs
from hairpipe.errors import BadInput


@pytest.fixture
def toy(shot, monkeypatch) -> Path:
    """The shot as a shipped graph called `set/toy`."""
    monkeypatch.setattr(shipped, "shipped_graphs", lambda: {"set/toy": shot})
    return shot


def test_the_demo_is_shipped():
    assert shipped_graphs()["demo"].is_file()


def test_a_file_comes_before_a_name(toy):
    assert find_graph("set/toy") == toy
    Path("set").mkdir()
    Path("set/toy").write_text("schema = 1")
    assert find_graph("set/toy") == Path("set/toy")


def test_a_folder_does_not_hide_a_name(toy):
    Path("set/toy").mkdir(parents=True)
    assert find_graph("set/toy") == toy


def test_an_unknown_name_is_refused_with_the_nearest(toy):
    with pytest.raises(BadInput, match=r"no graph 'set/tyo' \(.*did you mean 'set/toy'"):
        find_graph("set/tyo")


def test_where_files_are_published(toy, tmp_path):
    by_path = open_graph("shot.toml", {}).nodes
    assert by_path["list"].publish == tmp_path / "out" / "list.txt"
    by_name = open_graph("set/toy", {}).nodes
    assert by_name["list"].publish == tmp_path / "graphs" / "set" / "out" / "list.txt"
    assert by_name["seed"].publish is None
