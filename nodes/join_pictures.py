"""Pictures of a frame side by side."""

from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Ge, Suffixes


@node(frames="each")
def join_pictures(
    pictures: tuple[File, ...], workspace: Workspace, *, columns: Annotated[int, Ge(1)] = 2, names: tuple[str, ...] = ()
) -> Annotated[File, Suffixes((".png",))]:
    """Arrange pictures of each frame side by side as PNG, for a film that compares them.

    columns  number of pictures in a row
    names    names of the pictures, written on each
    """
    from hairpipe.formats.pictures import check_names, write_below

    check_names(names, len(pictures))
    path = workspace / "pictures.png"
    files = {f"in.pictures.{n}": picture.path for n, picture in enumerate(pictures)}
    write_below(path, files, columns, dict(enumerate(names)))
    return File(path)
