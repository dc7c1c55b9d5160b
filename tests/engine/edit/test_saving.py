"""Settings written into a graph file: a difference of lines shows what else changed."""

import difflib
import errno
import os
import tomllib
from pathlib import Path

import pytest

from hairpipe.engine.edit import save_settings, with_settings
from hairpipe.errors import BadInput

GRAPHS = Path(__file__).resolve().parents[3] / "graphs"
TEXT = """schema = 1 # of files
[hair]
type = "simulate_hair"
in.groom   = "groom"   # odd   spaces
air = { drag = 2.0 } # slow
strain.tolerance = 0.02
points = [
  1, # one
  2,
]

# about wind
[hair.wind]
velocity = [0.0, 0.0, 1.0]

# the end
"""


def changes(before, after):
    """List the lines that went, and those that came."""
    lines = difflib.ndiff(before.splitlines(), after.splitlines())
    return [line for line in lines if line[0] in "+-"]


@pytest.mark.parametrize(
    ("target", "value", "expected"),
    [
        ("hair.air.drag", 8.0, ["- air = { drag = 2.0 } # slow", "+ air = { drag = 8.0 } # slow"]),
        ("hair.strain.tolerance", 0.5, ["- strain.tolerance = 0.02", "+ strain.tolerance = 0.5"]),
        ("hair.strain.other", 1, ["+ strain.other = 1"]),
        ("hair.steps.longest", 1e-5, ["+ steps.longest = 1e-05"]),
        ("hair.model", "rod", ['+ model = "rod"']),
        ("hair.wind.gusts.size", 0.3, ["+ gusts.size = 0.3"]),
        ("hair.wind.velocity", [1.0, 0.0, 0.0], ["- velocity = [0.0, 0.0, 1.0]", "+ velocity = [1.0, 0.0, 0.0]"]),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_only_the_value_changes(target, value, expected, newline):
    text = TEXT.replace("\n", newline)
    after = with_settings(text, {target: value})
    assert changes(text, after) == expected
    assert after.count("\n") == after.count(newline)


def test_a_new_line_is_at_the_end_of_its_table_above_comments_of_the_next():
    assert ']\nmodel = "rod"\n\n# about wind\n' in with_settings(TEXT, {"hair.model": "rod"})


@pytest.mark.parametrize(
    "path", sorted(GRAPHS.glob("*.toml")) + sorted(GRAPHS.glob("paper/*.toml")), ids=lambda p: p.stem
)
def test_in_our_graphs_one_line_more_is_all_that_a_new_setting_is(path):
    text = path.read_text(encoding="utf-8")
    nodes = [name for name, table in tomllib.loads(text).items() if isinstance(table, dict) and name != "wedge"]
    for node in nodes:
        (line,) = changes(text, with_settings(text, {f"{node}.quite.new": 1}))
        assert line == "+ quite.new = 1"


def test_a_file_without_an_end_of_line_and_with_a_byte_order_mark_is_kept_so(tmp_path):
    path = tmp_path / "shot.toml"
    path.write_bytes('\ufeff[hair]\ntype = "x"'.encode())
    save_settings(path, {"hair.drag": 2.0})
    assert path.read_bytes() == '\ufeff[hair]\ntype = "x"\ndrag = 2.0\n'.encode()


@pytest.mark.parametrize("target", ["hare.drag", "hair", "hair.in.groom.x"])
def test_an_unknown_target_is_bad_input(target):
    with pytest.raises(BadInput):
        with_settings(TEXT, {target: 1.0})


@pytest.mark.parametrize("text", ['["hair"]\ntype = "x"\n', 'hair.type = "x"\n', 'hair = { type = "x" }\n[a]\n'])
def test_saved_text_has_the_new_value_or_is_refused(text):
    try:
        assert tomllib.loads(with_settings(text, {"hair.wind.drag": 1.0}))["hair"]["wind"] == {"drag": 1.0}
    except BadInput as fault:
        assert str(fault).startswith("hair.wind.drag = 1.0 cannot be written")


def test_permissions_and_links_of_a_file_stay(tmp_path):
    path, other, link = tmp_path / "a.toml", tmp_path / "b.toml", tmp_path / "c.toml"
    path.write_text(TEXT)
    path.chmod(0o640)
    save_settings(path, {"hair.air.drag": 3.0})
    assert path.stat().st_mode & 0o777 == 0o640
    other.hardlink_to(path)
    link.symlink_to(other)
    save_settings(link, {"hair.air.drag": 4.5})
    assert link.is_symlink() and path.samefile(other) and path.stat().st_mode & 0o777 == 0o640
    assert path.read_text() == TEXT.replace("drag = 2.0", "drag = 4.5")


def test_a_file_of_several_names_survives_a_full_disk(tmp_path, monkeypatch):
    path = tmp_path / "a.toml"
    path.write_text(TEXT)
    (tmp_path / "b.toml").hardlink_to(path)

    def full(file):
        monkeypatch.undo()
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="full"):
        save_settings(path, {"hair.air.drag": 4.5})
    assert path.read_text() == TEXT
