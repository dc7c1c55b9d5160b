"""A kernel folder stands for one state of the sources."""

import os
import sys

import pytest

from hairpipe.graph.key.code import CodeReader
from hairpipe.graph.run.machine_code import KEPT, kernel_folder, kernel_modules
from hairpipe.graph.run.pool import Pool

READER = CodeReader(lambda name, make: make())


def test_kernels_are_found_where_they_stand():
    found = set(kernel_modules())
    assert {"hairpipe.kernels.banded", "hairpipe.levelset.sample"} <= found
    assert not any(name.startswith("hairpipe.graph") for name in found)


@pytest.fixture
def studio(tmp_path, monkeypatch):
    """A node whose kernel calls one of a library of the user's, and a node without any."""
    library = tmp_path / "studio"
    library.mkdir()
    (library / "__init__.py").write_text("")
    (library / "helper.py").write_text("from numba import njit\n@njit\ndef twice(x):\n    return 2 * x\n")
    nodes = tmp_path / "nodes"
    nodes.mkdir()
    (nodes / "double_hair.py").write_text("from studio.helper import twice\n")
    (nodes / "name_hair.py").write_text("NAME = 'hair'\n")
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    return tmp_path


def folder_of(studio, *nodes):
    return kernel_folder(studio / "kernels", CodeReader(lambda name, make: make(), studio / "nodes"), nodes)


def test_an_edit_anywhere_gives_another_folder_and_an_undo_the_old_one(studio):
    helper = studio / "studio" / "helper.py"
    text, first = helper.read_text(), folder_of(studio, "double_hair")
    assert folder_of(studio, "double_hair") == first != folder_of(studio)
    helper.write_text(text.replace("2 * x", "x + x"))
    assert folder_of(studio, "double_hair") != first
    helper.write_text("# a comment\n" + text)
    assert folder_of(studio, "double_hair") == first


def test_nodes_that_compile_nothing_share_the_kernels_of_all(studio):
    assert folder_of(studio, "name_hair") == folder_of(studio)


def test_kernels_that_are_compiled_otherwise_have_another_folder(studio, monkeypatch):
    monkeypatch.delenv("NUMBA_OPT", raising=False)
    first = folder_of(studio)
    monkeypatch.setenv("NUMBA_OPT", "1")
    assert folder_of(studio) != first
    monkeypatch.delenv("NUMBA_OPT")
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    assert folder_of(studio) == first


def test_a_folder_that_is_used_is_young(studio):
    folder = folder_of(studio)
    folder.mkdir(parents=True)
    os.utime(folder, (0, 0))
    assert folder_of(studio) == folder and folder.stat().st_mtime > 0


def test_old_folders_go(tmp_path):
    for age in range(10):
        folder = tmp_path / f"state{age}"
        folder.mkdir()
        os.utime(folder, (age, age))
    current = kernel_folder(tmp_path, READER)
    current.mkdir()
    left = {folder.name for folder in tmp_path.iterdir()}
    assert len(left) == KEPT
    assert left == {current.name, *(f"state{age}" for age in range(11 - KEPT, 10))}


@pytest.mark.parametrize(("node", "edited"), [("double_hair", False), ("double_hair", True), ("name_hair", True)])
def test_kernels_go_that_may_be_of_code_edited_during_a_run(studio, node, edited):
    reader = CodeReader(lambda name, make: make(), studio / "nodes")
    reader.code_of(node)
    pool = Pool(studio, "json", studio / "nodes", 1, [node], reader)
    pool.kernels = studio / "kernels" / "state"
    kernel = pool.kernels / "studio" / "helper.twice-3.py311.1.nbc"
    kernel.parent.mkdir(parents=True)
    kernel.write_bytes(b"machine code")
    if edited:
        (studio / "studio" / "helper.py").write_text("twice = float\n")
        (studio / "nodes" / "name_hair.py").write_text("name_hair = str\n")
    pool.close()
    assert kernel.exists() != (edited and node == "double_hair") and kernel.parent.exists()
