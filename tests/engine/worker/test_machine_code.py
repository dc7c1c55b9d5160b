"""Which compiled kernels are current: the table for processes, and what is removed."""

import os
import sys
import time
from pathlib import Path

import pytest

from hairpipe.engine import code
from hairpipe.engine.code import CodeReader
from hairpipe.engine.worker import machine_code
from hairpipe.engine.worker.machine_code import FOLDER_DIGITS, KEPT, NOTES, UNUSED, kernel_digests, kernels_environment


def test_kernels_are_found_where_they_stand_and_other_rooms_compile_nothing():
    found = set(machine_code.kernel_modules())
    assert {"hairpipe.geometry.banded", "hairpipe.levelset.sample"} <= found
    assert not any(name.startswith("hairpipe.engine") for name in found)
    root = Path(machine_code.__file__).parents[2]
    files = [path for room in machine_code.WITHOUT_KERNELS for path in (root / room).rglob("*.py")]
    lines = [line for path in files for line in path.read_text().splitlines()]
    assert files and not [line for line in lines if line.startswith(("from numba", "import numba"))]


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
    monkeypatch.setenv("HAIRPIPE_TRUST", str(nodes))
    return tmp_path


def keys(studio, *nodes):
    """Keys of kernels, by module."""
    reader = CodeReader(lambda name, make: make(), studio / "nodes")
    return {entry.module: entry.key for entry in kernel_digests(reader, nodes).values()}


def test_an_edit_of_a_library_changes_keys_of_its_users_and_an_undo_restores_them(studio):
    helper = studio / "studio" / "helper.py"
    text, first = helper.read_text(), keys(studio, "double_hair")
    assert first.keys() - keys(studio).keys() == {"double_hair", "studio.helper"}
    helper.write_text(text.replace("2 * x", "x + x"))
    edited = keys(studio, "double_hair")
    assert {name for name in first if first[name] != edited[name]} == {"double_hair", "studio.helper"}
    helper.write_text("# a comment\n" + text)
    assert keys(studio, "double_hair") == first


def test_nodes_that_compile_nothing_share_the_kernels_of_all(studio):
    assert keys(studio, "name_hair") == keys(studio)


def test_an_edit_of_ours_changes_what_imports_it(studio, monkeypatch):
    """Levels of a hierarchy: what all use, what one model of a strand is, and a solver that no level set needs."""

    def changed_by(module):
        first = keys(studio)
        source = CodeReader._source

        def edited(reader, name):
            found = source(reader, name)
            return type(found)("edited", found.imports) if found is not None and name == module else found

        with monkeypatch.context() as patch:
            patch.setattr(CodeReader, "_source", edited)
            second = keys(studio)
        return {name for name in first if first[name] != second[name]}

    solver = changed_by("hairpipe.solve.conjugate_gradients")
    assert "hairpipe.solve.conjugate_gradients" in solver and "hairpipe.shot.simulate" in solver
    assert not solver & {"hairpipe.solve.implicit_stage", "hairpipe.levelset.sample", "hairpipe.geometry.simd"}
    lanes = changed_by("hairpipe.geometry.simd")
    assert {"hairpipe.geometry.banded", "hairpipe.strands.chain"} <= lanes
    assert not lanes & {"hairpipe.geometry.vec3", "hairpipe.levelset.sample"}


def test_kernels_that_are_compiled_otherwise_have_other_keys(studio, monkeypatch):
    monkeypatch.delenv("NUMBA_OPT", raising=False)
    first = keys(studio)
    monkeypatch.setenv("NUMBA_OPT", "1")
    assert not first.items() & keys(studio).items()
    monkeypatch.delenv("NUMBA_OPT")
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    assert keys(studio) == first


def test_a_table_of_one_state_is_one_file(studio):
    reader = CodeReader(lambda name, make: make())
    variables = [kernels_environment(studio, reader) for _ in range(2)]
    assert variables[0] == variables[1] and len(list(studio.glob("table-*"))) == 1


def test_analyses_are_kept_next_to_kernels_where_a_new_store_finds_them(studio, monkeypatch):
    def forget(name, make):
        raise AssertionError("a new store has no analysis")

    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(["studio.helper"]))
    kernels_environment(studio, CodeReader(forget))
    monkeypatch.setattr(code, "read_source", forget)
    kernels_environment(studio, CodeReader(forget))


def make_states(folder, module, ages):
    """Make folders of kernels of a module, last used so long ago [s]."""
    for number, age in enumerate(ages):
        state = folder / f"{module}-{number:0{FOLDER_DIGITS}x}"
        state.mkdir()
        (state / "kernel.nbc").write_text("")
        os.utime(state, (time.time() - age,) * 2)


def test_kernel_states_unused_for_longest_are_removed_first(tmp_path):
    make_states(tmp_path, "often", range(100, 100 + KEPT + 3))
    make_states(tmp_path, "rarely", [UNUSED - 100, UNUSED + 100])
    os.utime(tmp_path / f"often-{KEPT + 2:0{FOLDER_DIGITS}x}")
    (tmp_path / NOTES).mkdir()
    os.utime(tmp_path / NOTES, (time.time() - UNUSED - 100,) * 2)
    machine_code.remove_unused(tmp_path)
    often = {f"often-{number:0{FOLDER_DIGITS}x}" for number in [*range(KEPT - 1), KEPT + 2]}
    assert {path.name for path in tmp_path.iterdir()} == {NOTES, f"rarely-{0:0{FOLDER_DIGITS}x}"} | often
