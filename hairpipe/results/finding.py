"""Finds results files and pages by page, graph, results file or folder."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.plain_file import content
from hairpipe.results.file import FOLDER, read_results, results_path
from hairpipe.results.pages import names_of

PAGE, GRAPH, RESULTS = ".md", ".toml", ".json"
RIGHT = "a page (.md), a graph (.toml), a results file (.json), or a folder"


def find_results(given: Iterable[Path]) -> list[Path]:
    """List the results files of pages, graphs and folders; BadInput for other paths."""
    found: dict[Path, None] = {}
    for path in given:
        if path.is_dir():
            found |= dict.fromkeys(file for file in files_below(path, RESULTS) if file.parent.name == FOLDER)
        elif path.suffix == PAGE:
            found |= dict.fromkeys(results_path(path.parent, name) for name in names_of(read_page(path)))
        elif path.suffix == GRAPH and path.is_file():
            files = sorted((path.parent / FOLDER).glob(f"*{RESULTS}"))
            found |= dict.fromkeys(file for file in files if read_results(file).graph == path.name)
        elif path.suffix == RESULTS:
            found[path] = None
        else:
            raise BadInput("no results belong to it", where=path, right=RIGHT)
    return list(found)


def find_pages(given: Iterable[Path]) -> list[Path]:
    """List the pages among paths, and those in folders that contain figures."""
    found: dict[Path, None] = {}
    for path in given:
        if path.is_dir():
            found |= dict.fromkeys(page for page in files_below(path, PAGE) if names_of(read_page(page)))
        elif path.suffix == PAGE:
            found[path] = None
        else:
            raise BadInput("not a page", where=path, right="a page (.md) or a folder")
    return list(found)


def read_page(path: Path) -> str:
    """Read a page; BadInput if it cannot be read."""
    try:
        return content(path, "a page").decode("utf-8")
    except UnicodeDecodeError:
        raise BadInput("not text in UTF-8", where=path, right="a page") from None


def files_below(folder: Path, suffix: str) -> Iterator[Path]:
    """Iterate over files with a suffix below a folder, in order, without hidden folders."""
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (Path(place, name) for name in sorted(files) if name.endswith(suffix))
