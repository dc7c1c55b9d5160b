"""Node types are found by their file names, and loading them disturbs nothing."""

import shutil
import sys

import pytest

from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.file.trust import Untrusted
from hairpipe.engine.node.import_paths import EXPERIMENTS, OUR_NODES, folder_of
from hairpipe.errors import BadInput


def test_output_of_an_import_is_not_a_result(shot, capsys):
    shot.edit("make_seed.py", "from pathlib", "print('hello')\nfrom pathlib")
    sys.modules.pop("make_seed", None)
    Registry(shot.nodes).find("make_seed")
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err == "hello\n"


def test_a_node_type_cannot_have_the_name_of_a_module_of_python(shot):
    (shot.nodes / "json.py").write_text("")
    with pytest.raises(BadInput, match="hides a module of Python"):
        Registry(shot.nodes).find("json")


def test_a_type_of_the_experiments_is_found_only_next_to_them():
    home = folder_of(EXPERIMENTS)
    assert Registry(home).find("measure_writhe").name == "measure_writhe"
    code = CodeReader(lambda name, make: make(), home).code_of("measure_writhe")
    assert {"measure_writhe", "hairpipe.graphs.experiments.studies.theory.twist_buckling"} <= code.parts.keys()
    with pytest.raises(BadInput, match=r"only graphs in .*experiments find it"):
        Registry().find("measure_writhe")


def test_a_graph_next_to_our_nodes_finds_those_that_every_graph_finds():
    beside = Registry(folder_of(OUR_NODES)).find("make_bust")
    assert beside is Registry().find("make_bust") and beside.module == f"{OUR_NODES}.make_bust"


def test_an_installation_without_experiments_has_no_folder_of_them():
    assert folder_of(f"{EXPERIMENTS}.absent") is None


def test_a_folder_of_the_same_name_is_not_trusted(tmp_path):
    copy = shutil.copytree(folder_of(EXPERIMENTS), tmp_path / "graphs" / "experiments" / "nodes")
    (copy / "measure_writhe.py").write_text("1 / 0")
    with pytest.raises(Untrusted):
        Registry(copy).find("measure_writhe")
