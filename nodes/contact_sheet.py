"""Pictures of films on one sheet."""

from typing import Annotated

from hairpipe.engine import File, Frames, Time, Workspace, node
from hairpipe.units import Ge, Suffixes


@node(frames="once")
def contact_sheet(
    pictures: tuple[Frames[File], ...],
    workspace: Workspace,
    time: Time,
    *,
    frames: tuple[int, ...] = (),
    columns: Annotated[int, Ge(1)] = 1,
    names: tuple[str, ...] = (),
    times: bool = False,
) -> Annotated[File, Suffixes((".png",))]:
    """Arrange pictures in rows as PNG; films follow each other, at the same frames.

    frames   frames of the run to show; empty: all
    columns  number of pictures in a row
    names    names of the films, written on the first picture of each
    times    times since the first frame, written on every picture
    """
    from hairpipe.formats.pictures import check_names, write_below

    check_names(names, len(pictures))
    path = workspace / "sheet.png"
    numbers = pictures[0].numbers
    shown = [frame for frame in numbers if not frames or frame in frames] or numbers[:1]
    moments = [f"{(frame - numbers[0]) / time.fps:.2f} s" if times else "" for frame in shown]
    words = {film * len(shown): name for film, name in enumerate(names)}
    films = enumerate(pictures)
    files = {f"in.pictures.{n}, frame {frame}": film[frame].path for n, film in films for frame in shown}
    write_below(path, files, columns, words, moments)
    return File(path)
