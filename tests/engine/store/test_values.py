"""Values of a store: those at hand and those from the disk are one and the same."""

import errno
import os
import shutil
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from hairpipe.engine.node.declare import File
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import LostObject, Record, Store
from hairpipe.engine.store.values import Values, check_space
from hairpipe.formats import hdf5


@pytest.fixture
def values(tmp_path):
    """Values of a store, with memory for a few."""
    return Values(Store(tmp_path), 5_000_000)


@dataclass(frozen=True)
class Maps:
    """Arrays by name."""

    maps: dict[str, np.ndarray]


def test_a_value_at_hand_has_its_names_in_the_order_of_the_one_on_disk(tmp_path):
    """A node that goes through them in order gives one result, whoever computed what it is given."""
    there = Values(Store(tmp_path), limit=1 << 20)
    name = there.put(Maps({"b": np.ones(2), "a": np.zeros(2)}), Maps, None).object
    elsewhere = Values(Store(tmp_path), limit=0)
    orders = [list(values.get(name, Maps).maps) for values in (there, elsewhere)]
    assert orders == [["a", "b"], ["a", "b"]]


def test_values_that_are_kept_stay_under_the_limit(values):
    names = [values.put(np.full(125_000, float(i)), np.ndarray, None).object for i in range(20)]
    assert sum(hdf5.nbytes(tree) for tree in values._trees.values()) <= 5_000_000
    assert [values.get(name, np.ndarray)[0] for name in names] == list(range(20))
    assert values._held == sum(hdf5.nbytes(tree) for tree in values._trees.values()) <= 5_000_000


def test_the_value_that_was_used_last_stays_at_hand(tmp_path):
    values = Values(Store(tmp_path), 2 * hdf5.nbytes(hdf5.take_apart(np.zeros(100))))
    first, second, third = (values.put(np.full(100, number), np.ndarray, None).object for number in (1.0, 2.0, 3.0))
    values.get(second, np.ndarray)
    fourth = values.put(np.full(100, 4.0), np.ndarray, None).object
    for name in (first, second, third, fourth):
        values.store.remove(values.store.object_path(name))
    assert [values.get(name, np.ndarray)[0] for name in (second, fourth)] == [2.0, 4.0]
    for name in (first, third):
        with pytest.raises(LostObject):
            values.get(name, np.ndarray)
        assert values.lost() == name and values.lost() is None


def test_a_file_whose_list_of_companions_is_missing_is_lost(tmp_path):
    values, name = Values(Store(tmp_path), 0), f"{'0c' * 20}.set"
    with pytest.raises(LostObject, match=name):
        values.get(name, File)
    assert values.lost() == name


class Stale:
    """A function of files whose handle is stale for a number of calls in a row."""

    def __init__(self, function, times):
        self.function, self.left = function, times

    def __get__(self, path, owner):
        return partial(self, path)

    def __call__(self, *given, **named):
        self.left -= 1
        if self.left >= 0:
            raise OSError(errno.ESTALE, f"errno = {errno.ESTALE}")  # in words, as HDF5 reports it
        return self.function(*given, **named)


CALLS = {"read_text": (Path, "read_text"), "open": (Path, "open"), "stat": (Path, "stat"), "os.open": (os, "open")}
CALLS |= {"HDF5": (hdf5.h5py, "File"), "rename": (Path, "replace")}


@pytest.mark.parametrize(("owner", "name"), CALLS.values(), ids=CALLS)
def test_a_stale_handle_of_the_store_is_opened_again_three_times(tmp_path, monkeypatch, owner, name):
    """Whatever is read and written: records, values, files with companions. With more, the fault is reported."""
    store = Store(tmp_path / "store")
    (tmp_path / "a.txt").write_text("a")
    file = File(tmp_path / "a.txt", {"b": tmp_path / "a.txt"})
    touched = []

    def use(step, times):
        with monkeypatch.context() as patch:
            fault = Stale(getattr(owner, name), times)
            patch.setattr(owner, name, fault)
            found = step()
        touched.append(fault.left < 0)
        return found

    def try_all(times):
        values = Values(store, 1 << 20)
        output = use(lambda: values.put(np.arange(3.0), np.ndarray, None), times)
        files = use(lambda: values.put(file, File, None), times)
        parts = {"type": "a", "code": "b", "settings": {}, "inputs": {}, "time": None}
        record = Record("0" * 40, "a", None, parts, {"": output}, None, 1.0, (), 1.0)
        use(lambda: store.add(record), times)
        assert use(lambda: store.find(record.key), times) == record
        fresh = Values(store, 1 << 20)
        assert use(lambda: fresh.get(output.object, np.ndarray), times).tolist() == [0.0, 1.0, 2.0]
        assert use(lambda: fresh.get(files.object, File), times).companions["b"].read_text() == "a"

    try_all(3)
    assert any(touched)
    shutil.rmtree(store.root)
    with pytest.raises((OSError, AssertionError, LostObject)):
        try_all(4)


def test_space_is_looked_for_where_a_store_will_be(tmp_path):
    check_space(tmp_path / "shows" / "store", 1)
    with pytest.raises(OSError, match="No space left"):
        check_space(tmp_path / "shows" / "store", 1 << 60)


def test_a_node_gets_a_copy_of_its_own(values):
    mine = np.arange(6.0).reshape(2, 3)
    name = values.put(mine.T, np.ndarray, None).object
    mine[:] = 0
    given = values.get(name, np.ndarray)
    assert given.flags.c_contiguous and given.flags.writeable and given[1, 1] == 4.0
    given[:] = 0
    assert values.get(name, np.ndarray)[1, 1] == 4.0


def test_a_value_that_is_not_written_is_leased_and_has_the_size_of_its_file(tmp_path):
    values, others = Values(Store(tmp_path), 5_000_000), Leases(Store(tmp_path))
    found = values.put(np.arange(6.0), np.ndarray, None, lasting=False)
    assert list(values.get(found.object, np.ndarray)) == [0, 1, 2, 3, 4, 5]
    assert not values.store.has(found.object) and others.is_in_memory(found.object)
    values.write_out()
    assert values.store.size(found.object) == found.size and not others.is_in_memory(found.object)
    forgotten = values.put(np.arange(7.0), np.ndarray, None, lasting=False)
    values.forget(forgotten.object)
    assert not values.store.has(forgotten.object) and not others.is_in_memory(forgotten.object)


def test_a_value_that_two_scans_continue_from_is_forgotten_after_both(values):
    name, again = (values.put(np.arange(6.0), np.ndarray, None, lasting=False).object for _ in range(2))
    assert name == again
    values.forget(name)
    assert list(values.get(name, np.ndarray)) == [0, 1, 2, 3, 4, 5]
    values.forget(name)
    assert not values.unwritten and not Leases(values.store).is_in_memory(name)


def test_a_state_that_stays_equal_is_forgotten_once_it_changes(values):
    """As of hair at rest: after each frame the state before is forgotten."""
    states = [values.put(np.full(6, 1.0), np.ndarray, None, lasting=False).object]
    for value in (1.0, 1.0, 2.0):
        states.append(values.put(np.full(6, value), np.ndarray, None, lasting=False).object)
        values.forget(states[-2])
        assert list(values.unwritten) == [states[-1]]


def test_a_value_that_another_process_has_in_memory_is_written(tmp_path):
    """The other process forgets it without asking."""
    values, others = (Values(Store(tmp_path), 5_000_000) for _ in range(2))
    name = others.put(np.arange(6.0), np.ndarray, None, lasting=False).object
    assert values.put(np.arange(6.0), np.ndarray, None, lasting=False).object == name
    assert values.store.has(name) and not values.unwritten
    others.forget(name)
    assert list(values.get(name, np.ndarray)) == [0, 1, 2, 3, 4, 5]


def test_values_that_are_not_written_stay_under_the_limit(tmp_path):
    """The oldest is written, and the latest stays in memory whatever its size."""
    values = Values(Store(tmp_path), 1_500)
    names = [values.put(np.full(100, float(i)), np.ndarray, None, lasting=False).object for i in range(3)]
    assert [values.store.has(name) for name in names] == [True, True, False]
    large = values.put(np.zeros(1000), np.ndarray, None, lasting=False).object
    assert list(values.unwritten) == [large]
