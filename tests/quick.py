"""A plugin of pytest, for `make quick`: whatever needs compiled kernels is skipped at the moment it asks for one.

Tests of this process are skipped by numba's dispatcher. Tests whose other processes compile are skipped when these have
left kernels in their folder, which is empty at first; the long ones are marked `kernels` and do not begin.
"""

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

_FOLDER = tempfile.TemporaryDirectory(prefix="hairpipe-quick-")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip what compiles in other processes, and give those an empty folder for kernels."""
    os.environ["NUMBA_CACHE_DIR"] = _FOLDER.name
    for item in items:
        if item.get_closest_marker("kernels"):
            item.add_marker(pytest.mark.skip(reason="its processes compile kernels"))


def refuse(self: Dispatcher, sig: object) -> None:
    """Skip the test that calls a kernel, or the file that does so when it is imported."""
    pytest.skip("compiles kernels", allow_module_level=True)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Skip a test whose processes have compiled."""
    yield
    if any(Path(_FOLDER.name).rglob("*.nbi")):
        for folder in Path(_FOLDER.name).iterdir():
            shutil.rmtree(folder)
        pytest.skip("its processes compile kernels")


Dispatcher.compile = refuse
