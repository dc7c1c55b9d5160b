"""A plugin of pytest, for `make quick`: whatever needs compiled kernels is skipped at the moment it asks for one.

In this process numba is asked; tests whose other processes would compile are marked `kernels`, and one that is not
fails: kernels are looked for in a folder of its own.
"""

import os
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
    """Skip the test that calls a kernel."""
    pytest.skip("compiles kernels")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test whose processes have compiled."""
    yield
    if any(Path(_FOLDER.name).rglob("*.nbi")):
        pytest.fail("its processes compile kernels: mark it `kernels`")


Dispatcher.compile = refuse
