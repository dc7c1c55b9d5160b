"""Stores that earlier versions have written: later ones read them, or refuse them in one line.

`kept/VERSION` is the store of a toy shot of two frames (`graphs/experiments/bench/toy_shot.py`), without notes. A
version that changes the format adds its own, and leaves those of others as they are.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from hairpipe.engine.plan.maintenance import Found, verify
from hairpipe.engine.store.digest import action_key
from hairpipe.engine.store.store import Store
from hairpipe.engine.store.values import read_listing
from hairpipe.formats import hdf5

KEPT = sorted((Path(__file__).parent / "kept").iterdir())
VALUES = {("seed", None): 3.0, ("move", 1): 4.0, ("move", 2): 5.0, ("sum", 1): 8.0, ("sum", 2): 2.0 * (5.0 + 0.9 * 4.0)}
"""What the nodes of the shot compute: seed 3, plus the frame, added up with a decay of 0.9, twice."""


@pytest.fixture(params=KEPT, ids=lambda path: path.name)
def store(request, tmp_path):
    return Store(shutil.copytree(request.param, tmp_path / "store"))


@pytest.fixture
def records(store):
    found = [store.record(key) for key in store.record_keys()]
    return {(record.node, record.frame): record for record in found}


def test_records_have_the_keys_of_their_parts(records):
    assert records.keys() == VALUES.keys() | {("list", None)}
    assert all(action_key(record.parts) == record.key for record in records.values())


def test_values_are_those_that_were_computed(store, records):
    for (node, frame), value in VALUES.items():
        outputs = records[node, frame].outputs
        tree = hdf5.read(store.object_path(outputs["number" if node == "sum" else ""].object))
        np.testing.assert_allclose(tree["value"], np.full(16, value), rtol=1e-15)


def test_a_file_with_a_companion_is_whole(store, records):
    listing = read_listing(store, records["list", None].outputs[""].object)
    assert store.object_path(listing.path).read_text() == "[8.0, 17.2]"
    assert store.object_path(listing.companions["parts/sum.txt"]).read_text() == "25.2"


def test_nothing_in_it_is_taken_for_damaged(store):
    assert verify(store, hdf5.digest_file) == Found()
    assert len(list(store.object_names())) == 9
