"""Files of the data folder, which the environment or the place of the checkout names, and no graph."""

from pathlib import Path

import pytest

from hairpipe.engine.file import bounds as room
from hairpipe.engine.file.load import load_graph
from hairpipe.errors import BadInput

GRAPH = """schema = 1
frames = [1, 2]
fps = 24
[body]
type = "load_body"
file{}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data folder with one file."""
    monkeypatch.setenv("HAIRPIPE_DATA", str(tmp_path / "data"))
    (tmp_path / "data" / "bodies").mkdir(parents=True)
    (tmp_path / "data" / "bodies" / "a.obj").write_text("v 0 0 0\n")
    return tmp_path


def load(folder: Path, file: str):
    (folder / "shot.toml").write_text(GRAPH.format(file))
    return load_graph(folder / "shot.toml")


def test_a_file_of_the_data_folder_is_found_by_its_name(folder):
    graph = load(folder, '.data = "bodies/a.obj"')
    assert graph.settings(graph.nodes["body"])["file"] == str(folder / "data" / "bodies" / "a.obj")
    other = load_graph(folder / "shot.toml", {"body.file": "data/bodies/a.obj"})
    assert other.file(other.nodes["body"].settings["file"]) == folder / "data" / "bodies" / "a.obj"


OUTSIDE = r"file\.data = .* is outside of the data folder"
MISSING = r"shot.toml:6.*b\.obj' does not exist \(.*HAIRPIPE_DATA.*hairpipe data check"


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ('.data = "bodies/b.obj"', MISSING),
        *((f".data = {name}", OUTSIDE) for name in ('"../a.obj"', '"/etc/a.obj"', "3", '{ data = "a.obj" }')),
        ('= { data = "bodies/a.obj", unit = 1 }', "file = "),
    ],
)
def test_a_file_outside_the_folder_is_refused(folder, file, message):
    with pytest.raises(BadInput, match=message):
        load(folder, file)


def test_without_the_variable_it_lies_next_to_the_checkout(monkeypatch, tmp_path):
    monkeypatch.delenv("HAIRPIPE_DATA", raising=False)
    home = Path(__file__).resolve().parents[3]
    assert room.data_folder() == home.parent / "shared" / "data"
    installed = tmp_path / "site-packages" / "hairpipe" / "__init__.py"
    monkeypatch.setattr(room.hairpipe, "__file__", str(installed))
    assert room.data_folder() is None
    with pytest.raises(BadInput, match="HAIRPIPE_DATA is not set"):
        load(tmp_path, '.data = "bodies/a.obj"')
