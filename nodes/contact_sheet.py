"""Some pictures of a film on one sheet."""

from typing import Annotated

from hairpipe.graph import File, Frames, Workspace, node
from hairpipe.units import Ge


@node(frames="once")
def contact_sheet(
    pictures: Frames[File],
    workspace: Workspace,
    *,
    frames: tuple[int, ...] = (),
    columns: Annotated[int, Ge(1)] = 1,
) -> File:
    """PNG of pictures in rows.

    frames   shown, as far as they are run; all, where none is named
    columns  pictures in a row
    """
    from hairpipe.io.panels import write_below

    path = workspace / "sheet.png"
    shown = [frame for frame in pictures.numbers if not frames or frame in frames] or pictures.numbers[:1]
    write_below(path, [pictures[frame].path for frame in shown], columns)
    return File(path)
