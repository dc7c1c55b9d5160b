"""Saving changes values, and nothing else in the file."""

import difflib
import tomllib

import pytest

from hairpipe.errors import BadInput
from hairpipe.graph.file.save import save_settings

TEXT = """# A graph.
schema = 1 # first

[hair]
type = "simulate_hair" # what
in = { groom = "groom" , body="body" }   # odd   spaces
strain.tolerance = 0.02 # dotted
stiction = { reach = 0.9e-3, release = 2.2e-3 } # inline

  # indented
  [hair.wind] # a table
  velocity = [0.0, 0.0,
    -3.0] # over lines

[groom] # no settings
type = "grow_groom"
"""


@pytest.mark.parametrize(
    "target, value, old, new",
    [
        ("hair.strain.tolerance", 0.05, "strain.tolerance = 0.02 #", "strain.tolerance = 0.05 #"),
        ("hair.stiction.reach", 1e-3, "reach = 0.9e-3,", "reach = 0.001,"),
        ("hair.wind.velocity", [1.0, 2.0, 3.0], "[0.0, 0.0,\n    -3.0] #", "[1.0, 2.0, 3.0] #"),
        ("hair.type", "other", '"simulate_hair" #', '"other" #'),
    ],
)
def test_one_value_changes(target, value, old, new, tmp_path):
    path = tmp_path / "graph.toml"
    path.write_text(TEXT)
    save_settings(path, {target: value})
    assert path.read_text() == TEXT.replace(old, new)


@pytest.mark.parametrize("target", ["groom.strands", "groom.length.value", "hair.air.drag", "hair.wind.gust.speed"])
def test_what_was_not_there_is_added_and_no_line_goes(target, tmp_path):
    path = tmp_path / "graph.toml"
    path.write_text(TEXT)
    save_settings(path, {target: 4})
    found = tomllib.loads(path.read_text())
    for name in target.split("."):
        found = found[name]
    assert found == 4
    changes = [line for line in difflib.ndiff(TEXT.splitlines(), path.read_text().splitlines()) if line[0] in "+-"]
    assert [line[0] for line in changes if line[1:].strip()] == ["+"]


def test_what_has_no_place_is_refused_and_the_file_stays(tmp_path):
    path = tmp_path / "graph.toml"
    path.write_text(TEXT)
    with pytest.raises(BadInput, match=r"'type' in 'hair\.type\.x' is no group"):
        save_settings(path, {"hair.type.x": 1})
    assert path.read_text() == TEXT
    with pytest.raises(BadInput, match="cannot be read"):
        save_settings(tmp_path / "none.toml", {"a.b": 1})
