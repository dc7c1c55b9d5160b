"""A process runs kernels of the code as it is: what may be in machine code is in the key that it is looked up by."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np
import pytest

from hairpipe import child
from hairpipe.engine.code import CodeReader
from hairpipe.engine.worker import machine_code
from hairpipe.engine.worker.machine_code import claim_kernels, codes_behind, kernels_environment, table
from hairpipe.geometry.simd import LanesType
from hairpipe.strands.chain import Chain
from hairpipe.strands.interface import Terms
from hairpipe.strands.registry import strand_models

STUDIO = {
    "__init__.py": "",
    "vectors.py": "from numba import njit\nSCALE = 2.0\n@njit(cache=True)\ndef scaled(x):\n    return SCALE * x\n",
    "solver.py": """from numba import njit
from studio.vectors import scaled
@njit(cache=True)
def solve(x):
    return scaled(x) + 1.0
""",
    "records.py": "from typing import NamedTuple\nclass Pair(NamedTuple):\n    a: float\n    b: float\n",
    "reading.py": "from numba import njit\n@njit(cache=True)\ndef first(pair):\n    return pair.a\n",
    "interface.py": """from numba import njit
def force(x):
    raise TypeError("compiled code alone calls it")
@njit(cache=True)
def push(x):
    return force(x)
""",
    "model.py": """from numba.core.extending import overload
from studio.interface import force
@overload(force)
def _force(x):
    return lambda x: 10.0 * x
""",
    "apart.py": "from numba import njit\n@njit(cache=True)\ndef apart(x):\n    return x - 1.0\n",
}
RUN = """
from hairpipe.engine.worker.machine_code import guard_kernels
guard_kernels()
import json, studio.model
from typing import NamedTuple
from studio.apart import apart
from studio.interface import push
from studio.reading import first
from studio.records import Pair
from studio.solver import solve
Own = NamedTuple("Own", [("c", float), ("a", float)])
values = {"solve": solve(3.0), "first": first(Pair(b=1.0, a=2.0)), "push": push(1.0), "apart": apart(1.0)}
assert first(Own(a=1.0, c=2.0)) == 1.0
read = {kernel.__name__: sum(kernel.stats.cache_hits.values()) for kernel in (solve, first, push, apart)}
print(json.dumps([values, read]))
"""
"""`Own` is of a module without a digest: what is compiled for it is not kept."""
VALUES = {"solve": 7.0, "first": 2.0, "push": 10.0, "apart": 0.0}
ALL, NONE = dict.fromkeys(VALUES, 1), dict.fromkeys(VALUES, 0)


class Studio:
    """A package with kernels; as ours, or as a user's."""

    def __init__(self, folder):
        self.folder, self.nodes = folder, []
        (folder / "studio").mkdir()
        for name, text in STUDIO.items():
            (folder / "studio" / name).write_text(text)

    def edit(self, module, before, after):
        path = self.folder / "studio" / f"{module}.py"
        text = path.read_text()
        assert before in text
        path.write_text(text.replace(before, after))

    def run(self, before=lambda: None):
        """Run the kernels in a new process; returns values, and how many of each were read, not compiled.

        It writes no bytecode: Python would take that for current after an edit of the same length in the same second.

        before  called between the digests and the process
        """
        reader = CodeReader(lambda name, make: make())
        variables = kernels_environment(claim_kernels(self.folder / "kernels"), reader, self.nodes)
        variables["PYTHONDONTWRITEBYTECODE"] = "1"
        before()
        done = subprocess.run(child.command(RUN), env=os.environ | variables, check=True, stdout=subprocess.PIPE)
        return json.loads(done.stdout)


MODULES = [f"studio.{name[:-3]}" for name in STUDIO if name != "__init__.py"]


@pytest.fixture
def studio(tmp_path, monkeypatch):
    """The package, as if it were ours."""
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(MODULES))
    return Studio(tmp_path)


@pytest.mark.kernels
def test_an_edit_compiles_again_what_it_is_in_and_nothing_else(studio):
    """Of a global in a callee's machine code; of a record whose fields a kernel reads by place; of neither."""
    assert studio.run() == [VALUES, NONE]
    studio.edit("vectors", "SCALE = 2.0", "SCALE = 4.0")
    assert studio.run() == [VALUES | {"solve": 13.0}, ALL | {"solve": 0}]
    studio.edit("vectors", "SCALE = 4.0", "SCALE = 2.0")
    studio.edit("records", "a: float\n    b: float", "b: float\n    a: float")
    studio.edit("apart", "x - 1.0", "x - 2.0")
    assert studio.run() == [VALUES | {"apart": -1.0}, ALL | {"first": 0, "apart": 0}]


@pytest.mark.kernels
def test_code_that_was_edited_since_its_digest_leaves_no_kernel(studio):
    value, _ = studio.run(before=lambda: studio.edit("vectors", "SCALE = 2.0", "SCALE = 4.0"))
    assert value["solve"] == 13.0
    studio.edit("vectors", "SCALE = 4.0", "SCALE = 2.0")
    assert studio.run() == [VALUES, ALL | {"solve": 0}]


@pytest.mark.kernels
def test_an_overload_registered_elsewhere_is_part_of_all_kernels_of_its_user(studio, monkeypatch):
    """The kernel that calls it does not import it."""
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(()))
    studio.nodes = MODULES
    assert studio.run() == [VALUES, NONE]
    studio.edit("model", "10.0 * x", "20.0 * x")
    assert studio.run() == [VALUES | {"push": 20.0}, NONE]


def test_kernels_of_a_strand_model_are_behind_its_record():
    """Solvers are compiled for the record, and call kernels of the model that they do not import."""
    reader = CodeReader(lambda name, make: make())
    for kind in strand_models().values():
        behind = set(reader.code_of(kind.model.__module__).parts)
        kernels = (kind.add_forces, kind.springs_from, kind.spring_constant, kind.predict, kind.hold_tip)
        chosen = [kernel for kernel in (*kernels, kind.follow_solve) if kernel is not None]
        assert {kernel.py_func.__module__ for kernel in chosen} <= behind


def test_types_name_the_modules_that_they_are_of():
    """Records within records, optional ones, arrays of lanes; a function that is an argument has no name."""
    arrays = [np.zeros(2)] * len(Chain._fields)
    terms = Terms(1.0, Chain(*arrays), 0.0, 1)
    codes = codes_behind((numba.typeof(terms), LanesType(numba.float64)))
    modules = {entry.module for entry in table().values() if codes and entry.key in codes}
    assert {"hairpipe.strands.chain", "hairpipe.strands.interface", "hairpipe.geometry.simd"} <= modules
    assert codes_behind((numba.optional(numba.float64), numba.typeof(arrays[0]))) == []
    assert codes_behind((numba.typeof(numba.njit(lambda x: x)),)) is None


@pytest.mark.kernels
def test_two_processes_do_not_compile_the_same_kernel(studio):
    """Both begin with an empty folder: each kernel is compiled by one of them, and read by the other."""
    with ThreadPoolExecutor() as pool:
        (one, read), (other, read_by_other) = (done.result() for done in [pool.submit(studio.run) for _ in range(2)])
    assert one == other == VALUES
    assert {name: read[name] + read_by_other[name] for name in VALUES} == ALL
