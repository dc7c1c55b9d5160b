"""Frames stream: a long run holds no more than a short one."""

import resource

import numpy as np

from hairpipe.graph.store.store import Store
from hairpipe.graph.store.values import Values
from hairpipe.io import hdf5


def test_values_that_are_kept_stay_under_the_limit(tmp_path):
    values = Values(Store(tmp_path), hdf5, 5_000_000)
    names = [values.put(np.full(125_000, float(i)), np.ndarray, None).object for i in range(20)]
    assert sum(hdf5.nbytes(tree) for tree in values._trees.values()) <= 5_000_000
    assert [values.get(name, np.ndarray)[0] for name in names] == list(range(20))
    assert values._held == sum(hdf5.nbytes(tree) for tree in values._trees.values()) <= 5_000_000


def test_a_node_gets_a_copy_of_its_own(tmp_path):
    values = Values(Store(tmp_path), hdf5, 5_000_000)
    mine = np.arange(6.0).reshape(2, 3)
    name = values.put(mine.T, np.ndarray, None).object
    mine[:] = 0
    given = values.get(name, np.ndarray)
    assert given.flags.c_contiguous and given.flags.writeable and given[1, 1] == 4.0
    given[:] = 0
    assert values.get(name, np.ndarray)[1, 1] == 4.0


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
    monkeypatch.setattr("hairpipe.graph.run.pool.MEMORY", 20 << 20)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert shot.run().exit_code == 0
    worker = int((shot.folder / "out" / "list.txt").read_text())
    assert worker < 140_000, f"{worker} kB for 200 MB of frames"
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 60_000
