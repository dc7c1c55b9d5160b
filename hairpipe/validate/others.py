"""Other solvers: the recorded errors and costs of a swing, next to those of hairpipe."""

from hairpipe.api.source import shipped_graphs
from hairpipe.results.file import read_results
from hairpipe.validate.validation import shipped_validations

RECORD = "results/swing.json"


def recorded_solvers() -> tuple[list[tuple[str, ...]], str]:
    """Return the table of solvers, its header first, and how it was recorded; BadInput where it is not installed."""
    found = read_results(shipped_graphs()[shipped_validations()[0]].parent / RECORD)
    table = found.tables["peers"]
    rows = [tuple(f"{value:.3g}" if isinstance(value, float) else str(value) for value in row) for row in table.rows]
    source = f"recorded at commit {found.commit[:7]} on {found.machine.processor} by `{found.command}`"
    return [tuple(line[1:]) for line in (tuple(table.columns), *rows)], source
