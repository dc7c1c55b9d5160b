"""A file per frame."""

from typing import Annotated

from numeral import Numeral
from tally import tally

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Suffixes


@node(frames="each")
def draw_number(number: Numeral, workspace: Workspace) -> Annotated[File, Suffixes((".png", ".txt"))]:
    """Draw a number as that many digits."""
    tally("draw_number")
    path = workspace / "picture"
    path.write_text(repr(number.value))
    return File(path)
