"""Machine code is generated of functions that are called, and of no others."""

import json
import os
import subprocess

import numba
import pytest

from hairpipe import child
from hairpipe.engine.code import CodeReader
from hairpipe.engine.worker import machine_code
from hairpipe.engine.worker.machine_code import claim_kernels, kernels_environment

MODULES = {
    "__init__.py": "",
    "inner.py": """from hairpipe.geometry.compile import inlined
@inlined
def twice(x):
    if x < 0.0:
        raise ValueError("negative")
    return 2.0 * x
""",
    "outer.py": """from numba import njit, prange
from kernels_here.inner import twice
@njit(cache=True)
def quadruple(x):
    return twice(twice(x))
@njit(cache=True, parallel=True)
def double_all(x):
    for i in prange(len(x)):
        x[i] = twice(x[i])
@njit(cache=True)
def factorial(n):
    return n * factorial(n - 1) if n > 1 else 1
@njit(cache=True)
def permutations(n):
    return factorial(n)
""",
}
RUN = """
from hairpipe.engine.worker.machine_code import guard_kernels
guard_kernels()
import json, sys
import numpy as np
from numba.core.codegen import CPUCodeLibrary
generated = []
finalize = CPUCodeLibrary._finalize_final_module
def noted(library):
    generated.append(library.name)
    finalize(library)
CPUCodeLibrary._finalize_final_module = noted
from kernels_here import outer
x = np.arange(3.0)
values = []
for name in sys.argv[1:]:
    if name == "double_all":
        outer.double_all(x)
        values.append(x.tolist())
    elif name == "refused":
        try:
            outer.quadruple(-1.0)
        except ValueError as error:
            values.append(error.args[0])
    else:
        values.append(getattr(outer, name)(3))
print(json.dumps([values, generated]))
"""


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run functions of a package in a new process; returns values, and libraries whose code was generated."""
    folder = tmp_path / "kernels_here"
    folder.mkdir()
    for name, text in MODULES.items():
        (folder / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    names = [f"kernels_here.{name[:-3]}" for name in MODULES if name != "__init__.py"]
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(names))

    def call(*functions):
        reader = CodeReader(lambda name, make: make())
        variables = kernels_environment(claim_kernels(tmp_path / "kernels"), reader, [])
        code = f"import sys; sys.argv[1:] = {list(functions)!r}; exec({RUN!r})"
        done = subprocess.run(child.command(code), env=os.environ | variables, check=True, stdout=subprocess.PIPE)
        return json.loads(done.stdout)

    return call


def test_the_patched_version_of_numba_is_the_installed_one():
    """Another one is not patched: compare `bench first-use` with and without the patch, then adapt or delete it."""
    assert numba.version_info[:2] == machine_code.KNOWN


def test_functions_within_others_have_no_code_of_their_own(run):
    """An inlined function, read from the folder of kernels too, and the body of a parallel loop."""
    values, generated = run("quadruple")
    assert values == [12.0] and "twice" not in generated and generated.count("quadruple") == 1
    values, generated = run("double_all")
    assert values == [[0.0, 2.0, 4.0]] and generated == ["double_all"]
    assert run("quadruple", "double_all")[0] == [12.0, [0.0, 2.0, 4.0]]


def test_recursion_and_errors_are_those_of_python(run):
    """In compiled functions, and in those read from the folder of kernels."""
    for _ in range(2):
        assert run("permutations", "refused")[0] == [6, "negative"]
