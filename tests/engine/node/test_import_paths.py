"""Files of a folder of nodes beside others of their name: what runs is what is keyed."""

import os
import sys

import pytest

from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.plan.planner import read_result
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.scheduler import run

NODE = '''"""A number that somebody else gives."""
{imports}
from tally import numeral
from numeral import Numeral
from hairpipe.engine import node

@node(frames="once")
def {name}() -> Numeral:
    """Give a number."""
    return numeral({value})
'''


@pytest.fixture
def studio(tmp_path, monkeypatch):
    """A folder that is on Python's path before that of the nodes."""
    (tmp_path / "studio").mkdir()
    monkeypatch.syspath_prepend(str(tmp_path / "studio"))
    return tmp_path / "studio"


def give(shot, name, **parts):
    """Make a graph of one node, of a type in a file of this name."""
    (shot.nodes / f"{name}.py").write_text(NODE.format(name=name, **parts))
    shot.write(f'schema = 1\nframes = [1, 1]\nfps = 24\n[one]\ntype = "{name}"\n')


def value(shot):
    assert shot.run().exit_code == 0
    return shot.value("one")


def test_a_helper_that_python_finds_elsewhere_is_neither_run_nor_keyed(shot, studio):
    (studio / "shared_tools.py").write_text("FACTOR = 2.0\n")
    (shot.nodes / "shared_tools.py").write_text("FACTOR = 3.0\n")
    give(shot, "give_factor", imports="from shared_tools import FACTOR", value="FACTOR")
    assert value(shot) == 2.0
    (shot.nodes / "shared_tools.py").write_text("FACTOR = 30.0\n")
    assert shot.plan()["one"].status == "cached"
    (studio / "shared_tools.py").write_text("FACTOR = 20.0\n")
    assert shot.plan()["one"].reason == "code shared_tools"
    sys.modules.pop("shared_tools")
    assert value(shot) == 20.0


def test_a_node_of_another_modules_name_leaves_that_one_alone(shot, studio):
    """Its own file runs and is keyed, and an import of the name leads to the other one, from its own file too."""
    (studio / "shapes.py").write_text("SIDES = 3.0\n")
    give(shot, "shapes", imports="import shapes as other", value="other.SIDES")
    assert value(shot) == 3.0
    assert sys.modules["shapes"].SIDES == 3.0
    give(shot, "shapes", imports="import shapes as other", value="-other.SIDES")
    assert shot.plan()["one"].reason == "code nodes/shapes"
    assert value(shot) == -3.0
    (studio / "shapes.py").write_text("SIDES = 13.0\n")
    assert shot.plan()["one"].reason == "code shapes"


def test_graphs_of_one_process_keep_their_helpers_apart(shot, monkeypatch):
    """Whichever was loaded last."""
    (shot.folder / "other").mkdir()
    first, other = shot, type(shot)(shot.folder / "other")
    monkeypatch.setenv("HAIRPIPE_TRUST", os.pathsep.join([str(first.nodes), str(other.nodes)]))
    for each, factor in ((first, 2.0), (other, 3.0)):
        (each.nodes / "aid" / "deep").mkdir(parents=True)
        (each.nodes / "aid" / "deep" / "most.py").write_text(f"FACTOR = {factor}\n")
        give(each, "give_factor", imports="from aid.deep.most import FACTOR", value="FACTOR")
    graph = first.load()
    assert value(other) == 3.0
    assert run(graph, first.store).exit_code == 0
    assert read_result(graph, first.store, Task("one", None)).value == 2.0
    assert other.plan()["one"].status == "cached"
    assert str(other.nodes) in sys.path and str(first.nodes) not in sys.path


def test_no_file_takes_the_place_of_our_own_package(shot):
    (shot.nodes / "hairpipe.py").write_text("")
    module = Registry(shot.nodes).find("make_box").module
    parts = CodeReader(lambda name, make: make(), shot.nodes).code_of(module).parts
    assert {"hairpipe.nodes.make_box", "hairpipe.values.body"} <= parts.keys()


@pytest.mark.parametrize("file", ["give_sides.py", "shapes/regular.py"])
def test_compiled_code_of_an_older_state_is_not_run(shot, file, monkeypatch):
    """Python takes it for that of the file as long as the size and the second of the last change are the same."""
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
    (shot.nodes / "shapes").mkdir()
    (shot.nodes / "shapes" / "regular.py").write_text("SIDES = 3.0\n")
    give(shot, "give_sides", imports="from shapes.regular import SIDES", value="1.0 * SIDES")
    path, known = shot.nodes / file, (0, 0)
    os.utime(path, known)
    assert value(shot) == 3.0
    path.write_text(path.read_text().replace("1.0 *", "2.0 *").replace("= 3.0", "= 6.0"))
    os.utime(path, known)
    assert value(shot) == 6.0
