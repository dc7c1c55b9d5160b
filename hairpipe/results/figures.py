"""Figures of a page by reference: `{TABLE; COLUMN; OTHER COLUMN=VALUE; REDUCTION; FORMAT}`, the last three as needed.

TABLE may name the results file before a dot, `../volume/shell.table`; otherwise it is that of the marker. Reductions
are those of REDUCTIONS, over all matching rows, and COUNT, the number of values that are not empty. FORMAT is that of
Python, `.2g` or `,d`. `{state; RESULTS}` is the word for current results or those of older code.
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graph.node.messages import nearest
from hairpipe.results.file import Results, Value, ValueTable, read_results, results_path

REDUCTIONS: dict[str, Callable[[Sequence[float]], float]] = {
    "largest": lambda values: max(map(abs, values)),
    "max": max,
    "min": min,
    "mean": lambda values: math.fsum(values) / len(values),
    "sum": math.fsum,
}
"""`largest` is the largest magnitude."""
STATE, COUNT = "state", "count"
FORM = "{TABLE; COLUMN; OTHER COLUMN=VALUE; REDUCTION; FORMAT}"


class Figures:
    """Looks up figures for a page.

    folder   of the page
    default  name of the default results, empty for none
    word_of  returns the word for the state of a results file
    """

    def __init__(self, folder: Path, default: str, word_of: Callable[[Path], str]) -> None:
        self._folder, self._default, self._word_of = folder, default, word_of
        self._known: dict[str, Results] = {}

    def results(self, name: str) -> Results:
        """Return the results of this name; BadInput if they cannot be read."""
        if name not in self._known:
            self._known[name] = read_results(results_path(self._folder, name))
        return self._known[name]

    def word(self, name: str) -> str:
        """Return the word for the state of the results of this name, in brackets."""
        return f"({self._word_of(results_path(self._folder, name))})"

    def texts(self, reference: str) -> list[str]:
        """Return the value of a reference in all matching rows; BadInput for an unknown name, or without a match."""
        table, *parts = [part.strip() for part in reference.split(";")]
        if not parts:
            raise BadInput(f"'{{{reference}}}' has no column", right=FORM)
        column, *rest = parts
        if table == STATE:
            return [self.word(column)]
        found = self._table(table)
        wanted = dict(part.split("=", 1) for part in rest if "=" in part)
        values: Sequence[Value] = values_of(found, column, wanted)
        spec = ""
        for part in rest:
            if part == COUNT:
                values = [sum(value not in ("", None) for value in values)]
            elif part in REDUCTIONS:
                values = [reduced(part, values)]
            elif "=" not in part:
                spec = part
        return [written(value, spec) for value in values]

    def _table(self, reference: str) -> ValueTable:
        name, _, table = reference.rpartition(".")
        tables = self.results(name or self._default).tables
        if table not in tables:
            raise BadInput(f"no table '{table}'", right=nearest(table, list(tables)))
        return tables[table]


def values_of(table: ValueTable, column: str, wanted: dict[str, str]) -> list[Value]:
    """Return the values of a column in the rows with the wanted values; BadInput if there are none."""
    for name in (column, *wanted):
        if name not in table.columns:
            raise BadInput(f"no column '{name}'", right=nearest(name, table.columns))
    places = {table.columns.index(name): value for name, value in wanted.items()}
    rows = [row for row in table.rows if all(is_equal(row[place], text) for place, text in places.items())]
    if not rows:
        raise BadInput(f"no row with {', '.join(f'{name}={value}' for name, value in wanted.items())}")
    return [row[table.columns.index(column)] for row in rows]


def is_equal(value: Value, text: str) -> bool:
    """Whether a value equals that of a page: numbers by value, others as text."""
    if isinstance(value, int | float):
        try:
            return value == float(text)
        except ValueError:
            return False
    return value == text


def reduced(name: str, values: Sequence[Value]) -> float:
    """Reduce values to one number; BadInput if one is not a number."""
    numbers = [value for value in values if isinstance(value, int | float)]
    if len(numbers) < len(values):
        raise BadInput(f"'{name}' of values that are not all numbers", right="a column of finite numbers")
    return REDUCTIONS[name](numbers)


def written(value: Value, spec: str) -> str:
    """Return a value in a format; a dash if there is no value.

    Large numbers have no exponent, exponents no leading zero, and `#.2g`, which keeps the zeros of 2.0, no final point.
    """
    if value is None:
        return "-"
    try:
        text = format(value, spec)
    except ValueError:
        raise BadInput(f"'{spec}' does not apply to {value!r}", right="a format of Python, such as .2g") from None
    text = f"{float(text):,.0f}" if "e+" in text else text.replace("e-0", "e-") if spec else text
    return text.removesuffix(".") if spec.startswith("#") else text
