"""A kernel folder stands for one state of the sources."""

import os

from hairpipe.graph.code import CodeReader
from hairpipe.graph.machine_code import KEPT, kernel_folder, kernel_modules

READER = CodeReader(lambda name, make: make())


def test_kernels_are_found_where_they_stand():
    found = set(kernel_modules())
    assert {"hairpipe.sim.banded", "hairpipe.levelset.sample"} <= found
    assert not any(name.startswith("hairpipe.graph") for name in found)


def test_an_edit_anywhere_gives_another_folder_and_an_undo_the_old_one(tmp_path):
    nodes = tmp_path / "nodes"
    nodes.mkdir()
    helper = nodes / "helper.py"
    helper.write_text("x = 1\n")
    first = kernel_folder(tmp_path / "kernels", READER, nodes)
    assert kernel_folder(tmp_path / "kernels", READER, nodes) == first
    helper.write_text("x = 2\n")
    assert kernel_folder(tmp_path / "kernels", READER, nodes) != first
    helper.write_text("x = 1\n")
    assert kernel_folder(tmp_path / "kernels", READER, nodes) == first


def test_old_folders_go(tmp_path):
    for age in range(10):
        folder = tmp_path / f"state{age}"
        folder.mkdir()
        os.utime(folder, (age, age))
    current = kernel_folder(tmp_path, READER)
    current.mkdir()
    left = {folder.name for folder in tmp_path.iterdir()}
    assert len(left) == KEPT
    assert left == {current.name, "state7", "state8", "state9"}
