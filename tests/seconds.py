"""A plugin of pytest that says where the time of the tests goes: seconds by file, and how many of them compile kernels.

`make test PYTEST='-p tests.seconds'`. What child processes compile counts as waiting. For a cold run, set
NUMBA_CACHE_DIR to an empty folder.
"""

from collections import defaultdict
from collections.abc import Generator
from typing import Any

import pytest

from hairpipe.engine.worker.machine_code import seconds_compiled

MOST_FILES = 40
COMPILED = "seconds of compilation"

seconds: dict[str, float] = defaultdict(float)
compiled: dict[str, float] = defaultdict(float)
before = 0.0


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Generator[None, Any, Any]:
    """Note in the report, which goes to the process that started this one, what has compiled since the last one."""
    global before
    report = yield
    report.user_properties = [(COMPILED, seconds_compiled() - before)]
    before = seconds_compiled()
    return report


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    file = report.nodeid.partition("::")[0]
    seconds[file] += report.duration
    compiled[file] += dict(report.user_properties).get(COMPILED, 0.0)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Write the files that take longest, and all of them together."""
    if hasattr(config, "workerinput"):
        return
    write = terminalreporter.write_line
    total, kernels = sum(seconds.values()), sum(compiled.values())
    write(f"{total:.0f} s of tests in all processes, {kernels:.0f} s of it compile kernels")
    for file in sorted(seconds, key=seconds.__getitem__, reverse=True)[:MOST_FILES]:
        write(f"{seconds[file]:7.1f} s {compiled[file]:7.1f} s  {file}")
