"""Kernels are loaded as they were written, or compiled again."""

import pickle
import threading

import pytest
from numba.core.caching import IndexDataCacheFile

from hairpipe.graph.plan.gc import verify
from hairpipe.graph.store.seal import is_sealed, removed

KERNEL = """
from numba import njit
from numeral import Numeral
from tally import numeral

from hairpipe.graph import node

@njit(cache=True)
def twice(x):
    return 2.0 * x

@node(frames="each")
def double_number(number: Numeral) -> Numeral:
    "Double a number by machine code."
    return numeral(twice(number.value))
"""


@pytest.fixture
def kernel(tmp_path):
    """A kernel as numba keeps it, of the class that the workers guard."""
    removed()
    kernel = IndexDataCacheFile(str(tmp_path), "twice-3.py311", (1.0, 2))
    kernel.save("float64", ("machine", b"code"))
    return kernel


def states(data):
    """A file with one bit flipped, cut short, without its digest, of another, and empty."""
    for bit in range(0, 8 * len(data), 3):
        yield data[: bit // 8] + bytes([data[bit // 8] ^ 1 << bit % 8]) + data[bit // 8 + 1 :]
    yield from (data[:-1], data[:20], b"", pickle.dumps("code of somebody else"), data + b"x")


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_damaged_kernel_is_never_loaded(kernel, tmp_path, suffix):
    (path,) = tmp_path.glob(f"*.{suffix}")
    whole = path.read_bytes()
    for damaged in states(whole):
        path.write_bytes(damaged)
        assert kernel.load("float64") is None and removed() == [path] and not path.exists()
        path.write_bytes(whole)
    assert kernel.load("float64") == ("machine", b"code") and removed() == []


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_folder_in_place_of_a_kernel_goes(kernel, tmp_path, suffix):
    (path,) = tmp_path.glob(f"*.{suffix}")
    path.unlink()
    path.mkdir()
    assert kernel.load("float64") is None
    kernel.save("float64", ("machine", b"code"))
    assert kernel.load("float64") == ("machine", b"code")


def test_a_kernel_that_is_not_there_is_no_damage(tmp_path):
    removed()
    assert IndexDataCacheFile(str(tmp_path), "f", 1).load("float64") is None and removed() == []


def test_kernels_are_whole_whoever_writes_them_at_once(tmp_path):
    """Several processes write one index: each file is there with its own digest at any moment."""

    def write(number):
        kernel = IndexDataCacheFile(str(tmp_path), "f", 1)
        for turn in range(20):
            kernel.save((number, turn), b"code" * number)
            kernel.load((number, turn))

    removed()
    threads = [threading.Thread(target=write, args=[number]) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert removed() == [] and all(map(is_sealed, tmp_path.glob("f*.nb?")))


def test_a_kernel_that_cannot_be_kept_costs_nothing_else(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    IndexDataCacheFile(str(tmp_path / "file"), "f", 1)._save_data("f.1.nbc", b"code")


def test_a_run_heals_damaged_kernels_and_says_so_once(shot, monkeypatch):
    """The kernels lie where numba was told; those of the store are nothing to us."""
    folder = shot.folder / "kernels"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder))
    (shot.nodes / "double_number.py").write_text(KERNEL)
    shot.path.write_text(shot.path.read_text() + '[twice]\ntype = "double_number"\nin.number = "move"\n')
    warned = []

    def listen(event):
        if event.kind == "warning":
            warned.append(event.message)

    assert shot.run(to=["twice"], report=listen).exit_code == 0
    files = list(folder.glob("hairpipe/*/*/*.nb?"))
    assert len(files) == 2 and not (shot.store.root / "kernels").exists() and warned == []
    for path in files:
        whole = path.read_bytes()
        path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    found = verify(shot.store, lambda path: path.stem, folder / "hairpipe").damaged
    assert sorted(found) == sorted(f"kernels/{path.name}" for path in files)
    assert shot.run(to=["twice"], seed__value=7).exit_code == 0 and all(map(is_sealed, files))
    for path in files:
        path.write_bytes(b"no kernel")
    assert shot.run(to=["twice"], seed__value=9, jobs=2, report=listen).exit_code == 0
    assert warned == ["compiled kernels were damaged, and are compiled again"] and all(map(is_sealed, files))
