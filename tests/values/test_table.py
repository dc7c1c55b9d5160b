"""Tables: what goes in comes out, in order, by way of the store too."""

import numpy as np
import pytest

from hairpipe.formats.hdf5 import decode, digest, encode
from hairpipe.values import Table
from hairpipe.values.table import joined, table_of_columns, table_of_rows

NAMES = ("scheme", "tip [m]", "steps", "speed [m/s]")
ROWS = [("ours", 0.25, 3, np.nan), ("theirs", -1e-300, 7, np.inf)]


def is_same(a: Table, b: Table) -> bool:
    return a.names == b.names and repr(list(a.rows())) == repr(list(b.rows()))


def test_rows_are_read_back_in_order_and_with_their_types():
    table = table_of_rows(NAMES, ROWS)
    assert len(table) == 2 and table.names == NAMES
    assert repr(list(table.rows())) == repr(ROWS)
    assert table.numbers["steps"].dtype == np.int64 and table.numbers["tip [m]"].dtype == np.float64
    assert table["scheme"] == ("ours", "theirs")


@pytest.mark.parametrize("rows", [ROWS, ROWS[:1], []])
def test_the_store_keeps_it_with_the_order_of_its_columns(tmp_path, rows):
    table = table_of_rows(NAMES, rows)
    encode(table, tmp_path / "table.h5")
    read = decode(tmp_path / "table.h5", Table)
    assert is_same(read, table) and digest(read) == digest(table)
    assert digest(table_of_columns({name: table[name] for name in reversed(NAMES)})) != digest(table)


def test_tables_join_for_any_order_of_columns():
    below = table_of_columns({name: table_of_rows(NAMES, ROWS[1:])[name] for name in reversed(NAMES)})
    both = joined([table_of_rows(NAMES, ROWS[:1]), below])
    assert is_same(both, table_of_rows(NAMES, ROWS))
    assert joined([both], ["a"], "which").names == ("which", *NAMES)
    assert joined([both, below], ["a", "b"])["case"] == ("a", "a", "b")
    assert len(joined([table_of_rows(NAMES, []), both])) == 2


def test_invalid_tables_are_refused():
    for columns in ({"a": [1, 2], "b": [1]}, {"a": [1, "x"]}, {"a": [[1, 2]]}, {"a": [None, 1]}):
        with pytest.raises(ValueError):
            table_of_columns(columns)
    with pytest.raises(ValueError, match="2 values: a, b"):
        table_of_rows(["a", "b"], [[1]])
    with pytest.raises(ValueError, match="columns a, another b"):
        joined([table_of_columns({"a": [1]}), table_of_columns({"b": [1]})])
    with pytest.raises(ValueError):
        joined([table_of_columns({"a": ["x"]}), table_of_columns({"a": [1]})])
