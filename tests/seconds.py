"""A plugin of pytest that says where the time of tests goes: seconds by file, waited, computed and compiling kernels.

`make test PYTEST='-p tests.seconds'`. Child processes that have ended are computing; what they compile is not told
apart. For a cold run, set NUMBA_CACHE_DIR to an empty folder.
"""

import os
from collections import defaultdict
from collections.abc import Generator
from typing import Any

import pytest

from hairpipe.engine.worker.machine_code import seconds_compiled

MOST_FILES = 60
SPENT = "seconds computing and compiling"

spent: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0.0])
before = [0.0, 0.0]


def read_clocks() -> list[float]:
    return [sum(os.times()[:4]), seconds_compiled()]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Generator[None, Any, Any]:
    """Note in the report, which goes to the process that started this one, what was spent since the last one."""
    global before
    report = yield
    now = read_clocks()
    report.user_properties = [(SPENT, [end - begin for begin, end in zip(before, now, strict=True)])]
    before = now
    return report


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    file = report.nodeid.partition("::")[0]
    new = [report.duration, *dict(report.user_properties).get(SPENT, [0.0, 0.0])]
    spent[file] = [a + b for a, b in zip(spent[file], new, strict=True)]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Write the files that take longest, and all of them together."""
    if hasattr(config, "workerinput"):
        return
    rows = sorted(spent.items(), key=lambda row: -max(row[1]))[:MOST_FILES]
    total = [sum(column) for column in zip(*spent.values(), strict=True)]
    terminalreporter.write_line("   wall computing compiling [s]")
    for file, row in [("all", total), *rows]:
        terminalreporter.write_line(" ".join(f"{value:8.1f}" for value in row) + f"  {file}")
