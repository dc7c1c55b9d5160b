"""A plugin of pytest that says where the time of the tests goes: seconds by file, and how many of them compile kernels.

`make test PYTEST='-p tests.seconds'`. What child processes compile counts as waiting. For a cold run, set
NUMBA_CACHE_DIR to an empty folder.
"""

import time
from collections import defaultdict
from collections.abc import Iterator

import pytest
from numba.core import event

MOST_FILES = 40
COMPILED = "seconds of compilation"


class Compilation(event.Listener):
    """Sums the seconds in which numba compiles; functions that are compiled within another count once."""

    def __init__(self) -> None:
        self.seconds = self._begun = 0.0
        self._depth = 0

    def on_start(self, event: event.Event) -> None:
        if self._depth == 0:
            self._begun = time.perf_counter()
        self._depth += 1

    def on_end(self, event: event.Event) -> None:
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.perf_counter() - self._begun


compilation = Compilation()
event.register("numba:compile", compilation)
seconds: dict[str, float] = defaultdict(float)
compiled: dict[str, float] = defaultdict(float)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Iterator[pytest.TestReport]:
    """Note in the report, which goes to the process that started this one, what has compiled since the last one."""
    report = yield
    report.user_properties = [(COMPILED, compilation.seconds)]
    compilation.seconds = 0.0
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
