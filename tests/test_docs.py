"""What the pages in `docs/` are made of: node types by purpose, their examples, labels, and cards of graphs."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from PIL import Image

import hairpipe
from hairpipe.app.api.node_types import node_types
from hairpipe.formats.values import write_value
from hairpipe.nodes.make_bust import make_bust

from .pages import DOCS, HOME, graphs_of, name_of, nodes_of, write_files

CATALOGUE = node_types()
SMALL = {
    "groom.strands": 12,
    "groom.segments": 5,
    "parts.voxel": 0.02,
    "surface.voxel": 0.02,
    "picture.width": 32,
    "picture.height": 32,
    "hairline.width": 32,
    "hairline.height": 32,
}
"""Settings of the graphs of tutorials with which they run in no time."""
LARGEST_FILM = 150_000
LARGEST_FILMS = 2_000_000
"""Bytes of one film, and of all: a repository keeps every version of them."""
WIDEST_FILM = 600


@pytest.fixture
def extension(monkeypatch):
    """Let Python find the extension of Sphinx that makes these pages."""
    monkeypatch.syspath_prepend(str(HOME / "docs"))


@pytest.mark.parametrize("name", CATALOGUE.names())
def test_node_type_is_on_the_page_of_its_purpose(name, extension):
    from extension.purposes import purpose_of

    purpose = purpose_of(CATALOGUE.find(name))
    pages = [page for page in DOCS if f":::{{nodes}} {purpose}\n" in page.read_text(encoding="utf-8")]
    assert len(pages) == 1


@pytest.mark.parametrize("name", CATALOGUE.names())
def test_example_of_a_node_type_connects_its_inputs(name, extension):
    from extension.examples import example_of

    node_type = CATALOGUE.find(name)
    source, text = example_of(node_type)
    [table] = tomllib.loads(text).values()
    assert table["type"] == name and (not source or (HOME / source).is_file())
    needed = {key for key, socket in node_type.sockets.items() if not socket.optional}
    connected = table.get("in", {}).keys()
    assert connected <= node_type.sockets.keys() and (source or needed <= connected)


@pytest.mark.parametrize("page", DOCS, ids=name_of)
def test_label_names_a_node_type(page):
    labels = re.findall(r"\{ref\}`([^`]+)`", page.read_text(encoding="utf-8"))
    assert set(labels) <= set(CATALOGUE.names())


def test_every_folder_of_graphs_is_in_the_gallery():
    page = (HOME / "docs/gallery.md").read_text(encoding="utf-8")
    folders = re.findall(r"^:::\{gallery\} ?(.*)$", page, re.MULTILINE)
    graphs = (path.parent.relative_to(HOME / "graphs") for path in (HOME / "graphs").rglob("*.toml"))
    assert {Path(folder) for folder in folders} == set(graphs)


def test_films_are_small_move_and_belong_to_a_recorded_run(extension):
    from extension.films import FILMS, films, measured

    sizes = {path.relative_to(FILMS).with_suffix("").as_posix(): path.stat().st_size for path in FILMS.rglob("*.webp")}
    assert sizes.keys() <= films().keys()
    assert all(size <= LARGEST_FILM for size in sizes.values()) and sum(sizes.values()) <= LARGEST_FILMS
    for name in sizes:
        film = films()[name]
        with Image.open(film.path) as shown:
            assert max(shown.size) <= WIDEST_FILM and 12 <= shown.n_frames <= measured(film)[1]["pictures"] <= 40


@pytest.mark.kernels
@pytest.mark.parametrize("page", [page for page in DOCS if list(graphs_of(page))], ids=name_of)
def test_graphs_of_a_tutorial_load_as_they_grow_and_run_in_the_end(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    write_files(page, tmp_path)
    write_value(tmp_path / "head.usd", make_bust(), 0, 24.0)
    for name, text in graphs_of(page):
        (tmp_path / name).write_text(text)
        shot = hairpipe.load(name)
    small = {key: value for key, value in SMALL.items() if key.partition(".")[0] in shot.nodes}
    first = shot.frames[0]
    assert shot.run(range(first, first + 2), set=small, jobs=1).ok


def test_the_notebook_is_written_from_its_page(extension):
    from extension.notebook import TUTORIAL, notebook_of

    written = TUTORIAL.with_suffix(".ipynb").read_text(encoding="utf-8")
    assert written == notebook_of(TUTORIAL.read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in json.loads(written)["cells"]]
    saved = {cell.partition("\n")[0]: cell.partition("\n")[2] for cell in cells if cell.startswith("%%writefile")}
    assert saved["%%writefile short.toml"].strip() == list(graphs_of(TUTORIAL))[-1][1].strip()
    nodes = {f"%%writefile nodes/{name}.py": text.strip() for name, text in nodes_of(TUTORIAL).items()}
    assert nodes.items() <= {line: text.strip() for line, text in saved.items()}.items()
