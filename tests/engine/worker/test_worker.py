"""The memory of workers: what is freed is kept, and a long run holds no more than a short one."""

import ctypes
import resource
import subprocess
import sys

import pytest

from hairpipe.engine.plan.planner import explain
from hairpipe.engine.plan.tasks import Task
from hairpipe.processor import processor_class

ROUNDS = """
import resource
from hairpipe.engine.worker.worker import keep_freed

{keep}
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

bytearray(1 << 26)
begun = faults()
for _ in range(5):
    bytearray(1 << 26)
print(faults() - begun)
"""


def faults(keep):
    program = ROUNDS.format(keep=keep)
    return int(subprocess.run([sys.executable, "-c", program], check=True, capture_output=True).stdout)


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="the C library has no mallopt")
def test_kept_memory_is_not_allocated_again():
    assert faults("keep_freed()") < 100 < faults("")


def test_workers_of_a_long_run_stay_small(shot, monkeypatch):
    """200 frames of a megabyte, gathered by a node that takes them all: no process comes near 200 MB."""
    monkeypatch.setenv("TOY_SIZE", "125000")
    source = (shot.nodes / "write_list.py").read_text()
    # ru_maxrss of a process begins with that of its parent; VmHWM is its own.
    measure = """    from pathlib import Path

    path.write_text(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
    if not parts:"""
    (shot.nodes / "write_list.py").write_text(source.replace("    if not parts:", measure))
    text = shot.path.read_text().replace("[1, 10]", "[1, 200]").replace('"sum"', '"move"')
    shot.path.write_text(text.replace('[sum]\ntype = "add_up"\nin.number = "move"\ncheckpoint = 4\n', ""))
    monkeypatch.setattr("hairpipe.engine.hosts.host.MEMORY", 20 << 20)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert shot.run().exit_code == 0
    worker = int((shot.folder / "out" / "list.txt").read_text())
    assert worker < 140_000, f"{worker} kB for 200 MB of frames"
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 60_000


def test_processor_seconds_of_children_count(shot):
    busy = "import time\\nwhile time.process_time() < 0.5: pass"
    child = f"""    import subprocess, sys

    subprocess.run([sys.executable, "-c", "{busy}"], check=True)
    if not parts:"""
    shot.edit("write_list.py", "    if not parts:", child)
    assert 0.5 < shot.run().processor["list"] < 5.0


def test_a_worker_on_a_processor_of_another_class_evaluates_nothing(shot, monkeypatch):
    monkeypatch.setattr("hairpipe.engine.hosts.host.processor_class", lambda: "z80")
    (failure,) = shot.run(to=["seed"]).failures
    assert failure.message.startswith("the processor of the worker is of class") and "(z80)" in failure.message
    assert not shot.tally()


def test_a_record_names_the_class_of_the_processor(shot):
    shot.run(to=["seed"])
    record = explain(shot.load(), shot.store, Task("seed", None)).record
    assert record is not None and record.processor_class == processor_class()
