"""A child process does the work: what it finds comes back, and its death does not take us along."""

import importlib
import json
import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from hairpipe import apart, child
from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.formats.registry import read_body, read_strands
from hairpipe.formats.usd.stage import open_stage

from .sources import HOME
from .works_apart import crash_the_second_time, end_by_signal, pid_of, recall_text, sleep_apart, spend_time


def test_returns_what_the_work_returns(tmp_path: Path) -> None:
    assert work_apart(os.path.join, tmp_path, "a") == str(tmp_path / "a")


def test_the_work_may_print() -> None:
    assert work_apart(os.system, "echo noise") == 0


def test_warnings_come_through() -> None:
    with pytest.warns(UserWarning, match="^careful$"):
        assert work_apart(warnings.warn, "careful") is None


def test_bad_input_comes_through_with_its_parts(tmp_path: Path) -> None:
    with pytest.raises(BadInput) as caught:
        work_apart(open_stage, tmp_path / "none.usd")
    fault = caught.value
    assert str(fault).startswith(f"{tmp_path / 'none.usd'}: the file cannot be read: No such file or directory (")
    assert fault.what.startswith("the file cannot be read") and fault.where == tmp_path / "none.usd"


def test_any_exception_of_a_reader_is_one_line_with_its_class(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"^\[1\]: not a readable file \(TypeError: the JSON object must be"):
        work_apart(json.loads, [1])
    with pytest.raises(BadInput, match=r"a\.xyz: not a readable \.xyz file \(FileNotFoundError: "):
        work_apart(os.listdir, tmp_path / "a.xyz")


def test_a_missing_library_is_not_the_fault_of_the_file() -> None:
    with pytest.raises(RuntimeError, match="No module named 'nowhere'"):
        work_apart(importlib.import_module, "nowhere")


def test_a_work_that_takes_all_memory_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="takes more than 4 GiB of memory"):
        work_apart(bytearray, 1 << 40)


def test_a_limit_of_the_caller_is_kept() -> None:
    """With 2 GiB at most allowed, work is done with that."""
    script = """
import os, resource
from pathlib import Path
from hairpipe import apart, child
from hairpipe.apart import work_apart

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
    for read in (read_body, lambda path: read_strands(path, 1.0, "y", None)):
        with pytest.raises(BadInput, match=r"deep\.usda: the reader crashes on the file \(SIG"):
            read(path)


def test_one_child_does_all_works() -> None:
    assert work_apart(pid_of, Path()) == work_apart(pid_of, Path()) != os.getpid()


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGABRT, signal.SIGKILL])
def test_after_a_crash_another_child_goes_on(number: int) -> None:
    before = work_apart(pid_of, Path())
    with pytest.raises(BadInput, match=rf"a\.abc: the reader crashes on the file \({signal.Signals(number).name}\)"):
        work_apart(end_by_signal, Path("a.abc"), number)
    assert work_apart(pid_of, Path()) != before


def test_a_work_does_not_fail_because_of_those_before_it(tmp_path: Path) -> None:
    assert [work_apart(crash_the_second_time, tmp_path) for _ in range(3)] == [1, 1, 1]


def test_an_opened_file_is_kept_with_its_warnings_until_it_changes(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"

    def read() -> tuple[str, int]:
        with pytest.warns(UserWarning, match="^careful with a.txt$"):
            return work_apart(recall_text, path)

    path.write_text("one")
    time.sleep(0.05)
    first = read()
    assert read() == first
    stamp = path.stat()
    path.write_text("two")
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    assert read() == ("two", first[1] + 1)


def test_a_file_that_may_change_within_a_tick_of_its_clock_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for words in ("one", "two", "six"):
            path.write_text(words)
            assert work_apart(recall_text, path)[0] == words


def test_paths_are_relative_to_the_folder_of_the_caller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in "ab":
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        assert work_apart(os.path.abspath, Path("c")) == str(tmp_path / name / "c")


@pytest.mark.slow
def test_a_limit_of_time_is_one_for_each_work() -> None:
    """The first works take most of the limit of one, the last one exceeds it."""
    script = """
import resource, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from hairpipe.apart import work_apart
from tests.works_apart import spend_time

resource.setrlimit(resource.RLIMIT_CPU, (1, resource.RLIM_INFINITY))
for end in (0.8, 1.5):
    work_apart(spend_time, Path("a"), end)
print("done", flush=True)
work_apart(spend_time, Path("a"), 60.0)
"""
    child = subprocess.run([sys.executable, "-c", script, HOME], capture_output=True, text=True)
    assert child.stdout == "done\n"
    assert "BadInput: a: takes more than 60 s of processor time" in child.stderr


def test_processor_time_includes_the_works_of_a_child() -> None:
    apart._end_child()
    works = [child.processor_time()]
    for end in (1.0, 1.4):
        work_apart(spend_time, Path(), end)
        works.append(child.processor_time())
    apart._end_child()
    works.append(child.processor_time())
    first, second, end = np.diff(works)
    assert 0.9 < first < 1.4 and 0.3 < second < 0.7 and end < 0.2


def test_a_forked_process_has_a_child_of_its_own() -> None:
    ours = work_apart(pid_of, Path())
    reading, writing = os.pipe()
    forked = os.fork()
    if not forked:
        os.write(writing, str(work_apart(pid_of, Path())).encode())
        os._exit(0)
    os.waitpid(forked, 0)
    theirs = int(os.read(reading, 100))
    assert theirs != ours == work_apart(pid_of, Path())
    with pytest.raises(ProcessLookupError):
        wait_for_end(theirs)


def wait_for_end(pid: int) -> None:
    """Wait for the end of a process that is not ours; ProcessLookupError when it has ended."""
    for _ in range(200):
        os.kill(pid, 0)
        time.sleep(0.02)


@pytest.mark.parametrize("end", ["", "import os; os._exit(1)", "import os; os.kill(os.getpid(), 9)"])
def test_the_child_ends_with_its_parent(end: str) -> None:
    script = f"""
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from hairpipe.apart import work_apart
from tests.works_apart import pid_of

print(work_apart(pid_of, Path()), flush=True)
{end}
"""
    child = subprocess.run([sys.executable, "-c", script, HOME], capture_output=True, text=True)
    with pytest.raises(ProcessLookupError):
        wait_for_end(int(child.stdout))


def test_a_child_ends_without_work_and_another_one_follows(monkeypatch: pytest.MonkeyPatch) -> None:
    apart._end_child()
    boot = "from hairpipe import apart; apart.IDLE = 0.05; apart.serve()"
    monkeypatch.setattr(apart, "command", lambda _: child.command(boot))
    first = work_apart(pid_of, Path())
    with pytest.raises(ProcessLookupError):
        for _ in range(200):
            apart._kept[0].process.poll()
            os.kill(first, 0)
            time.sleep(0.02)
    assert work_apart(pid_of, Path()) != first
    apart._end_child()


def test_an_interrupted_work_is_not_the_answer_of_the_next_one() -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(KeyboardInterrupt):
            work_apart(sleep_apart, Path(), 30.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert work_apart(os.path.basename, Path("a/b")) == "b"
