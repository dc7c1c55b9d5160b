"""Values of a store: those at hand and those from the disk are one and the same."""

from dataclasses import dataclass

import numpy as np

from hairpipe.graph.store.store import Store
from hairpipe.graph.store.values import Values
from hairpipe.io import hdf5


@dataclass(frozen=True)
class Maps:
    """Arrays by name."""

    maps: dict[str, np.ndarray]


def test_a_value_at_hand_has_its_names_in_the_order_of_the_one_on_disk(tmp_path):
    """A node that goes through them in order gives one result, whoever computed what it is given."""
    there = Values(Store(tmp_path), hdf5, limit=1 << 20)
    name = there.put(Maps({"b": np.ones(2), "a": np.zeros(2)}), Maps, None).object
    elsewhere = Values(Store(tmp_path), hdf5, limit=0)
    orders = [list(values.get(name, Maps).maps) for values in (there, elsewhere)]
    assert orders == [["a", "b"], ["a", "b"]]
