"""Tables as text: CSV reads back to the bit, Markdown is what people read."""

import csv
import math

import numpy as np
import pytest

from hairpipe.engine import Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.values import write_csv, write_markdown
from hairpipe.nodes.write_table import write_table
from hairpipe.values.table import table_of_rows

NAMES = ("scheme, how", "tip [m]", "steps")
ROWS = [('with "tension"', 1 / 3, 7), ("a|b", math.pi * 1e-300, -2), ("nothing", math.nan, 2**53 + 1)]
TABLE = table_of_rows(NAMES, ROWS)


def test_csv_reads_back_to_the_bit(tmp_path):
    write_csv(tmp_path / "table.csv", TABLE)
    with (tmp_path / "table.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert tuple(names) == NAMES
    assert [row[0] for row in rows] == [row[0] for row in ROWS]
    np.testing.assert_array_equal([float(row[1]) for row in rows], TABLE["tip [m]"])
    assert [int(row[2]) for row in rows] == [row[2] for row in ROWS]


def test_markdown_has_a_cell_for_every_value(tmp_path):
    write_markdown(tmp_path / "table.md", TABLE)
    assert (tmp_path / "table.md").read_text() == (
        "| scheme, how | tip [m] | steps |\n| --- | ---: | ---: |\n"
        '| with "tension" | 0.3333 | 7 |\n| a\\|b | 3.142e-300 | -2 |\n| nothing | - | 9007199254740993 |\n'
    )


def test_the_node_lays_tables_below_each_other(tmp_path):
    text = write_table((TABLE, TABLE), Workspace(tmp_path), format="markdown", cases=("one", "two")).path.read_text()
    assert text.splitlines()[0] == "| case | scheme, how | tip [m] | steps |"
    assert [line.split(" ")[1] for line in text.splitlines()[2:]] == ["one"] * 3 + ["two"] * 3
    for tables, cases in (((TABLE, table_of_rows(["a"], [[1]])), ()), ((TABLE,), ("one", "two"))):
        with pytest.raises(BadInput):
            write_table(tables, Workspace(tmp_path), cases=cases)
