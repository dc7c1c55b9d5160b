"""A table: named columns of equal length."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hairpipe.values.value import value

Column = np.ndarray | tuple[str, ...]
"""Numbers, (rows,) float64 or int64, or texts."""


@value
class Table:
    """Columns in order; a name contains its unit, as in "time [s]".

    `table_of_columns({"time [s]": times, "case": cases})` builds a table from arrays or lists, `table_of_rows` from
    rows.

    names    of all columns, in order
    numbers  columns of numbers by name, each (rows,) float64 or int64
    texts    columns of texts by name, each of as many texts
    """

    names: tuple[str, ...]
    numbers: dict[str, np.ndarray]
    texts: dict[str, tuple[str, ...]]

    def __len__(self) -> int:
        """Count the rows."""
        return len(self[self.names[0]]) if self.names else 0

    def __getitem__(self, name: str) -> Column:
        """Return a column; KeyError where there is none."""
        return self.texts[name] if name in self.texts else self.numbers[name]

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Iterate over the rows, as Python's own numbers and texts."""
        columns = [self[name] for name in self.names]
        return zip(*(c if isinstance(c, tuple) else c.tolist() for c in columns), strict=True)


def table_of_columns(columns: Mapping[str, Sequence[Any] | np.ndarray]) -> Table:
    """Make a table of columns by name; ValueError where one is neither numbers nor texts, or of another length."""
    made = {name: _column(name, values) for name, values in columns.items()}
    lengths = {name: len(values) for name, values in made.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"columns of different lengths: {lengths}")
    texts = {name: values for name, values in made.items() if isinstance(values, tuple)}
    numbers = {name: values for name, values in made.items() if isinstance(values, np.ndarray)}
    return Table(tuple(columns), numbers, texts)


def table_of_rows(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> Table:
    """Make a table of rows, each with a value for every name; ValueError as for `table_of_columns`."""
    if any(len(row) != len(names) for row in rows):
        raise ValueError(f"every row has {len(names)} values: {', '.join(names)}")
    return table_of_columns({name: [row[place] for row in rows] for place, name in enumerate(names)})


def _column(name: str, values: Sequence[Any] | np.ndarray) -> Column:
    """Make a column of texts, or of whole numbers as int64, or of others as float64."""
    if len(values) and all(isinstance(value, str) for value in values):
        return tuple(map(str, values))
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "biuf"):
        raise ValueError(f"column '{name}' holds neither numbers nor texts")
    return array.astype(np.int64 if array.size and array.dtype.kind in "biu" else np.float64)


def joined(tables: Sequence[Table], labels: Sequence[str] = (), label: str = "case") -> Table:
    """Lay tables with the same columns, in the order of the first, below each other; ValueError where columns differ.

    labels  labels of the tables, written to a first column; none without labels
    label   name of that column
    """
    names = tables[0].names
    if labels and (len(labels) != len(tables) or label in names):
        raise ValueError(f"{len(labels)} names for {len(tables)} tables with the columns {', '.join(names)}")
    for table in tables[1:]:
        if set(table.names) != set(names):
            raise ValueError(f"one table has the columns {', '.join(names)}, another {', '.join(table.names)}")
    columns: dict[str, list[Any]] = {name: [value for table in tables for value in table[name]] for name in names}
    if labels:
        whose = [text for text, table in zip(labels, tables, strict=True) for _ in range(len(table))]
        columns = {label: whose, **columns}
    return table_of_columns(columns)
