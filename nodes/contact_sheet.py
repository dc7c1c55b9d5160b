"""Some pictures of films on one sheet."""

from typing import Annotated

from hairpipe.graph import File, Frames, Time, Workspace, node
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
    """PNG of pictures in rows; several films follow each other, at the same frames.

    frames   shown, as far as they are run; all, where none is named
    columns  pictures in a row
    names    of the films, written on the first picture of each
    times    since the first frame of the run are written on every picture
    """
    from hairpipe.io.panels import check_names, write_below

    check_names(names, len(pictures))
    path, numbers = workspace / "sheet.png", pictures[0].numbers
    shown = [frame for frame in numbers if not frames or frame in frames] or numbers[:1]
    moments = [f"{(frame - numbers[0]) / time.fps:.2f} s" if times else "" for frame in shown]
    words = {film * len(shown): name for film, name in enumerate(names)}
    films = enumerate(pictures)
    files = {f"in.pictures.{n}, frame {frame}": film[frame].path for n, film in films for frame in shown}
    write_below(path, files, columns, words, moments)
    return File(path)
