"""Node types are found by their file names, and loading them disturbs nothing."""

import sys

import pytest

from hairpipe.errors import BadInput
from hairpipe.graph.file.registry import Registry


def test_what_a_file_prints_when_it_is_imported_is_no_result(shot, capsys):
    shot.edit("make_seed.py", "from pathlib", "print('hello')\nfrom pathlib")
    sys.modules.pop("make_seed", None)
    Registry(shot.nodes).find("make_seed")
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err == "hello\n"


def test_a_node_type_cannot_have_the_name_of_a_module_of_python(shot):
    (shot.nodes / "json.py").write_text("")
    with pytest.raises(BadInput, match="hides a module of Python"):
        Registry(shot.nodes).find("json")
