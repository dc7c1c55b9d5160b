"""Write a page as a folder that any browser opens from a share, without a server or network requests."""

import base64
import html
import os
import shutil
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from hairpipe.app.api.reports import Run
from hairpipe.app.api.selection import FrameSet
from hairpipe.app.api.shot import Shot, WedgeShot
from hairpipe.app.page.assets import LICENCES, SCRIPTS, STYLES, VENDOR, asset, page_html, page_in_one
from hairpipe.app.page.documents import ending, graph_document, output_of, state_document, wedge_document
from hairpipe.app.page.values import Shelf, script
from hairpipe.engine.store.atomic import sweep, workspace, write_text
from hairpipe.engine.store.ownership import make_own, own_folder
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import reduced

MOST_STRANDS, FEWEST_STRANDS = 2000, 100
BUNDLE = 1_500_000  # size of a data file from which a new one is begun [bytes]: few files with short loading times
QUALITY = 82  # quality of pictures, which are written as WebP
MARK = "data/graph.js"  # file that marks a folder as a report, which may be replaced
Progress = Callable[[int, int], None]  # called with the number of written documents, and of all


class Contents(NamedTuple):
    """Scripts by data file, the data file of every document, pictures, and most strands of a groom."""

    scripts: dict[str, str]
    files: dict[str, str]
    pictures: dict[str, bytes]
    strands: int

    @property
    def size(self) -> int:
        return sum(map(len, self.scripts.values())) + sum(map(len, self.pictures.values()))


def write_report(
    shot: Shot,
    place: Path,
    frames: FrameSet = None,
    *,
    wedge: WedgeShot | None = None,
    run: Run | None = None,
    most_bytes: float = 60e6,
    single: bool = False,
    progress: Progress = lambda done, of: None,
) -> Contents:
    """Write a report of the cached results of a shot, and of the variants of a wedge; return its contents.

    place       folder, which is created; or file, for a single one. An older report there is replaced
    run         run of the shot, or of the wedge, whose outcome is shown
    most_bytes  size limit, which determines the number of strands: at most `MOST_STRANDS`
    single      whether everything is in one file

    BadInput for another existing file or folder, or where `FEWEST_STRANDS` exceed the limit.
    """
    check_place(place, single)
    shelf = Shelf(MOST_STRANDS)
    contents = collect(shelf, plain_documents(shelf, shot, frames, wedge, run), most_bytes, progress)
    pictures = {name: f"pictures/{name}.webp" for name in contents.pictures}
    if single:
        encoded = {name: base64.b64encode(data).decode() for name, data in contents.pictures.items()}
        pictures = {name: f"data:image/webp;base64,{text}" for name, text in encoded.items()}
    index = script("index", {"files": contents.files, "pictures": pictures})
    if single:
        place.parent.mkdir(parents=True, exist_ok=True)
        write_text(place, page_in_one(index + "".join(contents.scripts.values())), place.parent)
        return contents
    for folder in ("data", "pictures", "page"):
        shutil.rmtree(place / folder, ignore_errors=True)
        (place / folder).mkdir(parents=True, exist_ok=True)
    for name in (*VENDOR, *LICENCES, *STYLES, *SCRIPTS):
        (place / "page" / name).write_bytes(asset(name).read_bytes())
    for name, data in contents.pictures.items():
        (place / pictures[name]).write_bytes(data)
    for name, text in {"index": index, **contents.scripts}.items():
        (place / "data" / f"{name}.js").write_text(text, encoding="utf-8")
    first = [f"data/{name}.js" for name in ("index", "graph", "state")]
    write_text(place / "index.html", page_html(first, live=False), place)
    return contents


def check_place(place: Path, single: bool) -> None:
    """Raise BadInput for an existing path that is not a report."""
    if single:
        if place.is_dir() or place.suffix.lower() not in (".html", ".htm"):
            raise BadInput("is not a file for a report", where=place, right="report.html")
    elif place.exists() and not (place.is_dir() and ((place / MARK).exists() or not any(place.iterdir()))):
        raise BadInput("the folder contains files that are not a report", where=place, right="a new or an empty folder")


def plain_documents(
    shelf: Shelf, shot: Shot, frames: FrameSet, wedge: WedgeShot | None, run: Run | None
) -> dict[str, Any]:
    """Describe graph, state and wedge, and add their results to the shelf."""
    found = shot.plan(frames)
    output = output_of(run)
    ended = {} if run is None else ending(run)
    shelf.take(shot, found)
    if wedge is None:
        state = state_document(shot, found, shelf.suffix, output)
        return {"graph": graph_document(shot), "state": state | {"verdict": state["verdict"] | ended}}
    variants = wedge.plan(frames)
    shelf.take(wedge, variants)
    state = state_document(shot, found, shelf.suffix) | {"wedge": True}  # the run was of the wedge
    described = wedge_document(wedge, variants, shelf.suffix, output, frames)
    return {
        "graph": graph_document(shot),
        "state": state,
        "wedge": described | {"verdict": described["verdict"] | ended},
    }


def collect(shelf: Shelf, documents: dict[str, Any], most_bytes: float, progress: Progress) -> Contents:
    """Make all documents; strands last, as many as the size limit allows."""
    names = list(chosen(shelf))
    hair = [name for name in names if name.endswith(".strands")]
    objects = list(dict.fromkeys(pictures_of(documents)))
    total = len(names) + len(objects)
    done = count(1)

    def written(name: str) -> str:
        text = script(name, *shelf.document(name))
        progress(next(done), total)
        return text

    pictures = {}
    for name in objects:
        pictures[name] = reduced(shelf.picture(name), QUALITY)
        progress(next(done), total)
    texts = {name: written(name) for name in names if name not in hair}
    texts |= {f"{name}.faces": script(f"{name}.faces", *packed) for name, packed in shelf.faces().items()}
    scripts = {name: script(name, document) for name, document in documents.items()}
    room = most_bytes - sum(map(len, (*texts.values(), *scripts.values(), *pictures.values())))
    shelf.most = strands_that_fit(shelf, hair, room)
    strands = {name: written(name) for name in hair}
    while (excess := sum(map(len, strands.values())) - room) > 0:  # few strands have more bytes per strand than many
        shelf.most = int(0.9 * shelf.most)
        if not hair or shelf.most < FEWEST_STRANDS:
            raise too_large(excess)
        strands = {name: script(name, *shelf.document(name)) for name in hair}
    bundles, files = bundled(texts | strands)
    return Contents(scripts | bundles, {name: name for name in scripts} | files, pictures, shelf.most)


def chosen(shelf: Shelf) -> Iterator[str]:
    """List the documents of a report: all but contacts, maps, and surfaces after the first frame."""
    seen: set[str] = set()
    for name in shelf.names():
        node = shelf.node_of(name)
        if name.endswith((".contacts", ".maps")):
            continue
        if name.endswith(".surface"):
            if node in seen:
                continue
            seen.add(node)
        yield name


def pictures_of(documents: dict[str, Any]) -> Iterator[str]:
    states = [documents["state"]["nodes"], *documents.get("wedge", {"states": []})["states"]]
    for cell in (cell for nodes in states for node in nodes.values() for cell in node["cells"]):
        yield from (cell["outputs"][output] for output in cell.get("pictures", {}))


def strands_that_fit(shelf: Shelf, names: list[str], room: float) -> int:
    """Return the number of strands of each groom whose documents have at most `room` bytes."""
    if not names:
        return MOST_STRANDS
    sample = names[:: max(1, len(names) // 8)]
    made = [(script(name, *packed), packed[0]["total"]) for name in sample for packed in [shelf.document(name)]]
    each = sum(len(text) / max(1, min(total, shelf.most)) for text, total in made) / len(made)
    fitting = int(room / (each * len(names)))
    if fitting < min(FEWEST_STRANDS, *(total for _, total in made)):
        raise too_large(each * len(names) * FEWEST_STRANDS - room)
    return min(MOST_STRANDS, fitting)


def too_large(excess: float) -> BadInput:
    """Describe a report that exceeds its size limit by `excess` bytes."""
    what = f"the report would take {excess / 1e6:.1f} MB too much"
    return BadInput(what, where="--size", right="more, or fewer --frames")


def bundled(texts: dict[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """Join the scripts of consecutive documents into data files; return these, and the data file of every document."""
    bundles: dict[str, str] = {}
    files: dict[str, str] = {}
    part, size = 0, 0
    for name, text in texts.items():
        files[name] = f"part{part}"
        bundles[files[name]] = bundles.get(files[name], "") + text
        size += len(text)
        if size >= BUNDLE:
            part = part + 1
            size = 0
    return bundles, files


REDIRECT = '<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0;url={}"><title>hairpipe</title>'


@contextmanager
def redirecting(address: str) -> Iterator[Path]:
    """Write a temporary file that redirects a browser to an address, readable by this user only."""
    folder = own_folder("state") / "pages"
    make_own(folder)
    sweep(folder)
    with workspace(folder) as place:
        path = place / "page.html"
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(REDIRECT.format(html.escape(address)))
        yield path


@contextmanager
def opened(address: str) -> Iterator[None]:
    """Open an address in the user's browser while it is served, if a file can be written that redirects to it.

    A command line, which every local user may read, has no secret address in it.
    """
    with ExitStack() as stack:
        with suppress(OSError):
            webbrowser.open(stack.enter_context(redirecting(address)).as_uri())
        yield
