"""Tables as text: CSV and Markdown."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hairpipe.data import Table
from hairpipe.data.table import joined
from hairpipe.errors import BadInput


def lay_below(tables: Sequence[Table], cases: Sequence[str]) -> Table:
    """Join tables below each other, see `joined`; BadInput where they do not match."""
    try:
        return joined(tables, cases)
    except ValueError as error:
        raise BadInput(str(error), right="tables with the same columns, and a name for each or none") from None


def write_csv(path: Path, table: Table) -> None:
    """Write the names and the rows, with numbers in full precision."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table.names)
        writer.writerows(table.rows())


def write_markdown(path: Path, table: Table) -> None:
    """Write a table of Markdown, numbers with four digits and to the right."""
    marks = ["---" if name in table.texts else "---:" for name in table.names]
    rows = [table.names, marks, *([formatted(value) for value in row] for row in table.rows())]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def formatted(value: Any) -> str:
    """Write a value of a table; a missing one as a dash."""
    if isinstance(value, float):
        return f"{value:.4g}" if math.isfinite(value) else "-" if math.isnan(value) else str(value)
    return str(value)
