"""A plugin of pytest, for `make quick`: tests that need no compiled kernels, and take little time.

A test that calls a kernel is skipped at that moment, by numba's dispatcher. Tests that compile in their processes, or
after long preparations, are marked `kernels`, and those that take seconds without compiling, in a browser or in many
processes, `slow`: they do not begin.
"""

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

_FOLDER = tempfile.TemporaryDirectory(prefix="hairpipe-quick-")
REASONS = {"kernels": "compiles kernels", "slow": "takes seconds"}
"""Markers of tests that do not begin."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip marked tests, and give the processes of others an empty folder for kernels."""
    os.environ["NUMBA_CACHE_DIR"] = _FOLDER.name
    for item in items:
        for name, reason in REASONS.items():
            if item.get_closest_marker(name):
                item.add_marker(pytest.mark.skip(reason=reason))


def refuse(self: Dispatcher, sig: object) -> None:
    """Skip the test that calls a kernel, or the file that does so when it is imported."""
    pytest.skip("compiles kernels", allow_module_level=True)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test whose processes have compiled: unmarked, it would take a minute each time."""
    yield
    if any(Path(_FOLDER.name).rglob("*.nbc")):
        for folder in Path(_FOLDER.name).iterdir():
            shutil.rmtree(folder)
        pytest.fail("its processes compile kernels: mark it `kernels`", pytrace=False)


Dispatcher.compile = refuse
