"""A file of all frames."""

from typing import Annotated

from numeral import Numeral
from tally import tally

from hairpipe.engine import File, Frames, Workspace, node
from hairpipe.units import Suffixes


@node(frames="once")
def write_list(
    numbers: Frames[Numeral], workspace: Workspace, *, parts: bool = False
) -> Annotated[File, Suffixes((".txt",))]:
    """List all numbers, in one file or with one part beside it."""
    tally("write_list")
    path = workspace / "list.txt"
    path.write_text("\n".join(f"{frame} {number.value!r}" for frame, number in numbers.items()))
    if not parts:
        return File(path)
    (workspace / "sums").write_text(repr(sum(number.value for number in numbers.values())))
    return File(path, {"parts/sums.txt": workspace / "sums"})
