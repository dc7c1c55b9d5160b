"""A table as a file."""

from typing import Annotated, Literal

from hairpipe.data import Table
from hairpipe.graph import File, Workspace, node
from hairpipe.units import Suffixes


@node(frames="once")
def write_table(
    tables: tuple[Table, ...],
    workspace: Workspace,
    *,
    format: Literal["csv", "markdown"] = "csv",
    cases: tuple[str, ...] = (),
) -> Annotated[File, Suffixes((".csv", ".md"))]:
    """CSV or Markdown of a table, below a row of names; several tables are laid below each other.

    format  csv has every digit, markdown four: one is for programs, the other for people
    cases   names of the tables, in order: a first column "case" names the one a row is from
    """
    from hairpipe.io.table import lay_below, write_csv, write_markdown

    write, name = {"csv": (write_csv, "table.csv"), "markdown": (write_markdown, "table.md")}[format]
    write(workspace / name, lay_below(tables, cases))
    return File(workspace / name)
