"""A child process does the work: what it finds comes back, and its death does not take us along."""

import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from hairpipe.errors import BadInput
from hairpipe.io.usd.apart import work_apart
from hairpipe.io.usd.read import read_body, read_curves
from hairpipe.io.usd.stage import check_file


def test_returns_what_the_work_returns(tmp_path: Path) -> None:
    assert work_apart(os.path.join, tmp_path, "a") == str(tmp_path / "a")


def test_the_work_may_print() -> None:
    assert work_apart(os.system, "echo noise") == 0


def test_warnings_come_through() -> None:
    with pytest.warns(UserWarning, match="^careful$"):
        assert work_apart(warnings.warn, "careful") is None


def test_bad_input_comes_through_with_its_parts(tmp_path: Path) -> None:
    with pytest.raises(BadInput) as caught:
        work_apart(check_file, tmp_path / "none.usd")
    fault = caught.value
    assert str(fault).startswith(f"{tmp_path / 'none.usd'}: the file cannot be read: No such file or directory (")
    assert fault.what.startswith("the file cannot be read") and fault.where == tmp_path / "none.usd"


def test_internal_errors_are_not_bad_input() -> None:
    with pytest.raises(RuntimeError, match="Expecting property name"):
        work_apart(json.loads, "{")


def test_a_work_that_takes_all_memory_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="takes more than 4 GiB of memory"):
        work_apart(bytearray, 1 << 40)


def test_a_limit_of_the_caller_is_kept() -> None:
    """With 2 GiB at most allowed, work is done with that."""
    script = """
import os, resource
from pathlib import Path
from hairpipe.io.usd.apart import work_apart

resource.setrlimit(resource.RLIMIT_DATA, (2 << 30, 2 << 30))
print(work_apart(os.path.join, Path("a"), "b"))
work_apart(bytearray, 1 << 40)
"""
    child = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert child.stdout == "a/b\n"
    assert "BadInput: 1099511627776: takes more than 2 GiB of memory" in child.stderr


def test_a_death_is_bad_input(tmp_path: Path) -> None:
    path = tmp_path / "deep.usda"
    path.write_text("#usda 1.0\n" + 'def Xform "a" {' * 200_000 + "}" * 200_000)
    for read in (read_body, read_curves):
        with pytest.raises(BadInput, match=r"deep\.usda: OpenUSD fails to read the file \(SIG"):
            read(path)
