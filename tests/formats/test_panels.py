"""Pictures side by side and below each other."""

import numpy as np
import pytest
from PIL import Image

from hairpipe.body.shapes import build_box
from hairpipe.engine import File, Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import GAP, write_below, write_png, write_side_by_side
from hairpipe.nodes.contact_sheet import contact_sheet
from hairpipe.nodes.join_pictures import join_pictures
from hairpipe.nodes.preview_meshes import preview_meshes


def plain(level, height=40, width=60):
    return np.full((height, width, 3), level, np.uint8)


def test_pictures_are_side_by_side_with_captions(tmp_path):
    write_side_by_side(tmp_path / "a.png", [plain(50), plain(150)], ("one", "two"), "")
    write_side_by_side(tmp_path / "b.png", [plain(50), plain(150)], (), "")
    worded, bare = (np.asarray(Image.open(tmp_path / name)) for name in ("a.png", "b.png"))
    assert worded.shape == bare.shape == (40, 120 + GAP, 3)
    assert (bare[:, :60] == 50).all() and (bare[:, 60 + GAP :] == 150).all()
    assert (worded != bare)[:20, :60].any() and (worded != bare)[:20, 60 + GAP :].any()
    assert not (worded != bare)[20:].any()


def test_pictures_fill_rows(tmp_path):
    paths = {str(i): tmp_path / f"{i}.png" for i in range(5)}
    for i, path in enumerate(paths.values()):
        write_png(path, plain(40 * i + 10))
    write_below(tmp_path / "sheet.png", paths, 2)
    sheet = np.asarray(Image.open(tmp_path / "sheet.png"))
    assert sheet.shape == (3 * 40 + 2 * GAP, 120 + GAP, 3)
    for i in range(5):
        row, column = divmod(i, 2)
        assert (sheet[row * (40 + GAP) + 20, column * (60 + GAP) + 30] == 40 * i + 10).all()


def test_words_stand_over_and_in_the_corners_of_what_they_belong_to(tmp_path):
    paths = {str(i): tmp_path / f"{i}.png" for i in range(4)}
    for path in paths.values():
        write_png(path, plain(90))
    write_below(tmp_path / "bare.png", paths, 2)
    write_below(tmp_path / "worded.png", paths, 2, {2: "third"}, ("", "late"))
    bare, worded = (np.asarray(Image.open(tmp_path / name)) for name in ("bare.png", "worded.png"))
    changed = (bare != worded).any(axis=2)
    places = [changed[top : top + 40, left : left + 60] for top in (0, 40 + GAP) for left in (0, 60 + GAP)]
    assert [bool(part[:20].any()) for part in places] == [False, False, True, False]
    assert [bool(part[20:].any()) for part in places] == [False, True, False, True]


def film_of(folder, height):
    """A film of two frames."""
    folder.mkdir()
    files = {frame: File(folder / f"{frame}.png") for frame in (1, 2)}
    for file in files.values():
        write_png(file.path, plain(90, height))
    return Frames((1, 2), files.__getitem__)


def test_films_of_several_sizes_are_refused(tmp_path):
    films = film_of(tmp_path / "one", 40), film_of(tmp_path / "two", 50)
    with pytest.raises(BadInput, match=r"in\.pictures\.1, frame 1: 60 x 50 pixels \(60 x 40 as the first"):
        contact_sheet(films, Workspace(tmp_path), Time(1, 24.0))


def test_names_of_nothing_are_refused(tmp_path):
    box, time = build_box((1.0, 1.0, 1.0), (0.0, 0.5, 0.0)), Time(1, 24.0)
    with pytest.raises(BadInput, match="names: 2 for 1 to be named"):
        preview_meshes((box,), Workspace(tmp_path), time, names=("one", "two"))
    with pytest.raises(BadInput, match="names: 2 for 1 to be named"):
        contact_sheet((film_of(tmp_path / "film", 40),), Workspace(tmp_path), time, names=("one", "two"))


def test_pictures_of_a_frame_are_side_by_side(tmp_path):
    left, right = (film_of(tmp_path / name, 40)[1] for name in ("left", "right"))
    joined = join_pictures((left, right), Workspace(tmp_path), names=("left", "right"))
    width, height = Image.open(left.path).size
    assert Image.open(joined.path).size == (2 * width + GAP, height)
