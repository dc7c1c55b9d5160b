"""A file per frame."""

from numeral import Numeral
from tally import tally

from hairpipe.graph import File, Workspace, node


@node(frames="each")
def draw_number(number: Numeral, workspace: Workspace) -> File:
    """Draw a number as that many digits."""
    tally("draw_number")
    path = workspace / "picture"
    path.write_text(repr(number.value))
    return File(path)
