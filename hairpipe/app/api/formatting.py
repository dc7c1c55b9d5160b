"""Formatting of numbers, names and tables."""

from collections.abc import Sequence
from pathlib import Path

from hairpipe.engine.node.messages import one_line

UNITS = ("B", "kB", "MB", "GB", "TB")


def table(rows: Sequence[Sequence[str]], align: str) -> str:
    """Lay out rows of cells in columns; a `<` or `>` for each column says on which side it is flush."""
    if not rows:
        return ""
    rows = [[one_line(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(f"{cell:{side}{width}}" for cell, side, width in zip(row, align, widths, strict=True)) for row in rows
    )
    return "\n".join(line.rstrip() for line in lines)


def markdown(rows: Sequence[Sequence[str]], align: str) -> str:
    """Write the same as a table of Markdown; the first row is its head."""
    if not rows:
        return ""
    head, *body = [[one_line(cell).replace("|", "\\|") for cell in row] for row in rows]
    marks = ["---:" if side == ">" else "---" for side in align]
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, marks, *body))


def size(count: float) -> str:
    """Write a number of bytes."""
    step = 0
    while count >= 999.5 and step < len(UNITS) - 1:
        count = count / 1000
        step = step + 1
    return f"{count:.0f} {UNITS[step]}" if step == 0 or count >= 99.5 else f"{count:.1f} {UNITS[step]}"


def duration(seconds: float) -> str:
    """Write a time span [s]: 0.31 s, 12.5 s, 2:05 min, 1:02:03 h."""
    if seconds < 59.95:
        return f"{seconds:.2f} s" if seconds < 9.995 else f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d} h" if hours else f"{minutes}:{rest:02d} min"


def plural(count: int, noun: str) -> str:
    """Write a number of things."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def shown(path: Path) -> str:
    """Write the path of a file, relative to the current folder if it is in it."""
    path = path.resolve()
    here = Path.cwd()
    return one_line(str(path.relative_to(here) if path.is_relative_to(here) else path))
