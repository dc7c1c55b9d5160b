"""Kernels are loaded as they were written, or compiled again."""

import pickle
import threading

import pytest
from numba.core.caching import IndexDataCacheFile

from hairpipe.engine.plan.maintenance import verify
from hairpipe.engine.store.fingerprint import is_sealed, is_there, removed

KERNEL = """
from numba import njit
from numeral import Numeral
from tally import numeral

from hairpipe.engine import node

@njit(cache=True)
def twice(x):
    return 2.0 * x

@node(frames="each")
def double_number(number: Numeral) -> Numeral:
    "Double a number by machine code."
    return numeral(twice(number.value))
"""


KEY = ("float64", "processor", "bytecode")


@pytest.fixture
def kernel(tmp_path):
    """A kernel as numba keeps it, of the class that the workers guard."""
    removed()
    kernel = IndexDataCacheFile(str(tmp_path), "twice-3.py311", (1.0, 2))
    kernel.save(KEY, ("machine", b"code"))
    return kernel


def states(data):
    """A file with one bit flipped, cut short, without its digest, of another, and empty."""
    for bit in range(0, 8 * len(data), 3):
        yield data[: bit // 8] + bytes([data[bit // 8] ^ 1 << bit % 8]) + data[bit // 8 + 1 :]
    yield from (data[:-1], data[:20], b"", pickle.dumps("code of somebody else"), data + b"x")


def test_a_damaged_kernel_is_never_loaded(kernel, tmp_path):
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    for damaged in states(whole):
        path.write_bytes(damaged)
        assert kernel.load(KEY) is None and removed() == [path] and not path.exists()
        path.write_bytes(whole)
    assert kernel.load(KEY) == ("machine", b"code") and removed() == []


def test_a_kernel_that_is_missing_is_not_there(kernel, tmp_path):
    (path,) = tmp_path.iterdir()
    assert is_there(path) and not is_there(tmp_path / "missing") and kernel.load(("int64", *KEY[1:])) is None
    assert removed() == []


def test_a_kernel_that_is_another_one_is_never_loaded(kernel, tmp_path):
    """Of other arguments or of other code, renamed or moved: the seal is of the place, too."""
    kernel.save(("int64", *KEY[1:]), ("other", b"code"))
    one, other = sorted(tmp_path.iterdir())
    swapped = [path.read_bytes() for path in (other, one)]
    for path, data in zip((one, other), swapped, strict=True):
        path.write_bytes(data)
    assert kernel.load(KEY) is None and len(removed()) == 1
    kernel.save(KEY, ("machine", b"code"))
    (tmp_path / "elsewhere").mkdir()
    moved = IndexDataCacheFile(str(tmp_path / "elsewhere"), "twice-3.py311", (1.0, 2))
    for path in tmp_path.glob("*.nbc"):
        (tmp_path / "elsewhere" / path.name).write_bytes(path.read_bytes())
    assert kernel.load(KEY) == ("machine", b"code") and moved.load(KEY) is None and len(removed()) == 1


def test_a_folder_in_place_of_a_kernel_goes(kernel, tmp_path):
    (path,) = tmp_path.iterdir()
    path.unlink()
    path.mkdir()
    assert kernel.load(KEY) is None
    kernel.save(KEY, ("machine", b"code"))
    assert kernel.load(KEY) == ("machine", b"code")


def test_kernels_are_whole_whoever_writes_them_at_once(tmp_path):
    """Each file is there with its own digest at any moment, and no process undoes what another one keeps."""

    def write(number):
        kernel = IndexDataCacheFile(str(tmp_path), "f", "stamp")
        for turn in range(20):
            for key in ((number, turn), (0, turn)):
                kernel.save((key, *KEY[1:]), key)
        assert [kernel.load(((number, turn), *KEY[1:])) for turn in range(20)] == [(number, turn) for turn in range(20)]

    removed()
    threads = [threading.Thread(target=write, args=[number]) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    kept = list(tmp_path.iterdir())
    assert removed() == [] and len(kept) == 80 and all(map(is_sealed, kept))


def test_a_kernel_that_cannot_be_kept_costs_nothing_else(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    IndexDataCacheFile(str(tmp_path / "file"), "f", "stamp").save(KEY, b"code")


@pytest.mark.kernels
def test_a_run_heals_damaged_kernels_and_reports_it_once(shot, monkeypatch):
    """The kernels lie where numba was told; those of the store are nothing to us."""
    folder = shot.folder / "kernels"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder))
    (shot.nodes / "double_number.py").write_text(KERNEL)
    shot.add('[twice]\ntype = "double_number"\nin.number = "move"\n')
    assert shot.run(to=["twice"]).exit_code == 0
    files = list(folder.glob("hairpipe/*/*.nb?"))
    assert len(files) == 1 and not (shot.store.root / "kernels").exists() and shot.warned == []
    for path in files:
        whole = path.read_bytes()
        path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    found = verify(shot.store, lambda path: path.stem, folder / "hairpipe").damaged
    assert sorted(found) == sorted(f"kernels/{path.name}" for path in files)
    assert shot.run(to=["twice"], seed__value=7).exit_code == 0 and all(map(is_sealed, files))
    for path in files:
        path.write_bytes(b"no kernel")
    assert shot.run(to=["twice"], seed__value=9, jobs=2).exit_code == 0
    assert [message for _, message in shot.warned] == ["compiled kernels were damaged, and are compiled again"]
    assert all(map(is_sealed, files))
