"""Numbers, names and tables as people read them."""

import pytest

from hairpipe.app.api.formatting import duration, plural, shown, size, table


@pytest.mark.parametrize(
    ("count", "text"),
    [
        *((0, "0 B"), (999, "999 B"), (1000, "1.0 kB"), (99_400, "99.4 kB"), (99_960, "100 kB"), (999_600, "1.0 MB")),
        *((3.2e9, "3.2 GB"), (5e15, "5000 TB")),
    ],
)
def test_sizes(count, text):
    assert size(count) == text


def test_durations_and_plurals():
    seconds = [0.0, 0.314, 12.34, 59.97, 125, 3723]
    assert list(map(duration, seconds)) == ["0.00 s", "0.31 s", "12.3 s", "1:00 min", "2:05 min", "1:02:03 h"]
    assert [plural(count, "result") for count in (0, 1, 1200)] == ["0 results", "1 result", "1,200 results"]


def test_columns_are_as_wide_as_their_widest_cell():
    assert table([("a", "1", "x"), ("long", "100", "")], "<><") == "a       1  x\nlong  100"
    assert table([], "<") == ""


def test_paths_are_relative_within_the_current_folder_only(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert shown(tmp_path / "a" / ".." / "b") == "b"
    assert shown(tmp_path.parent / "c") == str(tmp_path.parent / "c")
