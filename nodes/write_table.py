"""A table as a file."""

from typing import Annotated, Literal

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Suffixes
from hairpipe.values import Table


@node(frames="once")
def write_table(
    tables: tuple[Table, ...],
    workspace: Workspace,
    *,
    format: Literal["csv", "markdown"] = "csv",
    cases: tuple[str, ...] = (),
) -> Annotated[File, Suffixes((".csv", ".md"))]:
    """Write tables as CSV or Markdown, concatenated below a row of names.

    format  file format: csv with all digits for programs, markdown with four digits for people
    cases   names of the tables, in order, for a new first column "case"
    """
    from hairpipe.formats.values import lay_below, write_csv, write_markdown

    write, name = {"csv": (write_csv, "table.csv"), "markdown": (write_markdown, "table.md")}[format]
    write(workspace / name, lay_below(tables, cases))
    return File(workspace / name)
