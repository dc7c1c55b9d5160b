"""Pictures: read as paint, written as films and sheets."""

import warnings
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.body.shapes import build_box
from hairpipe.engine import File, Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import GAP, read_image, write_below, write_png, write_side_by_side, write_webp
from hairpipe.nodes.contact_sheet import contact_sheet
from hairpipe.nodes.join_pictures import join_pictures
from hairpipe.nodes.preview_meshes import preview_meshes


def picture(shift: int, size: tuple[int, int] = (40, 60)) -> np.ndarray:
    """A soft gradient with a bright bar that moves."""
    rows, columns = np.mgrid[: size[0], : size[1]]
    out = np.stack([rows * 3, columns * 2, np.full(size, 90)], axis=2).astype(np.uint8)
    out[:, shift : shift + 6] = 250
    return out


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    """Seven PNGs."""
    paths = [tmp_path / f"{n}.png" for n in range(7)]
    for n, path in enumerate(paths):
        write_png(path, picture(5 * n))
    return paths


def write(files: list[Path], path: Path, *, fps: float = 24.0, scale: float = 1.0) -> Path:
    """Write all files as an animation."""
    write_webp(path, range(len(files)), files.__getitem__, fps=fps, scale=scale, quality=80)
    return path


def test_png_keeps_every_pixel(files: list[Path]) -> None:
    with Image.open(files[3]) as image:
        assert image.format == "PNG" and np.array_equal(np.asarray(image), picture(15))


def test_equal_pictures_give_equal_bytes(files: list[Path], tmp_path: Path) -> None:
    write_png(tmp_path / "again.png", picture(15))
    assert (tmp_path / "again.png").read_bytes() == files[3].read_bytes()
    one, two = write(files, tmp_path / "one.webp"), write(files, tmp_path / "two.webp")
    assert one.read_bytes() == two.read_bytes()


def test_the_film_shows_every_picture_in_order(files: list[Path], tmp_path: Path) -> None:
    with Image.open(write(files, tmp_path / "film.webp")) as film:
        assert film.n_frames == 7 and film.size == (60, 40) and film.info["loop"] == 0
        for n in range(7):
            film.seek(n)
            assert np.asarray(film.convert("RGB"))[20, 5 * n + 3].min() > 200


def durations(path: Path) -> list[int]:
    """How long every picture is shown [ms]."""
    found = []
    with Image.open(path) as film:
        for n in range(film.n_frames):
            film.seek(n)
            film.load()
            found.append(film.info["duration"])
    return found


@pytest.mark.parametrize("fps", [24.0, 23.976, 30.0, 120.0])
def test_the_film_lasts_as_long_as_its_frames(files: list[Path], tmp_path: Path, fps: float) -> None:
    # whole milliseconds, without a drift
    assert sum(durations(write(files, tmp_path / "film.webp", fps=fps))) == pytest.approx(7 * 1000.0 / fps, abs=0.6)


@pytest.mark.parametrize(("frames", "shown"), [((1, 3, 5), [100, 100, 100]), ((8, 9, 12), [50, 150, 50])])
def test_frames_that_are_omitted_are_waited_for(
    files: list[Path], tmp_path: Path, frames: tuple[int, ...], shown: list[int]
) -> None:
    by_frame = dict(zip(frames, files, strict=False))
    write_webp(tmp_path / "film.webp", frames, by_frame.__getitem__, fps=20.0, scale=1.0, quality=80)
    assert durations(tmp_path / "film.webp") == shown


def test_one_picture_is_a_film(files: list[Path], tmp_path: Path) -> None:
    with Image.open(write(files[:1], tmp_path / "film.webp")) as film:
        assert film.n_frames == 1 and film.size == (60, 40)


def test_the_film_can_be_smaller(files: list[Path], tmp_path: Path) -> None:
    with Image.open(write(files, tmp_path / "film.webp", scale=0.5)) as film:
        assert film.size == (30, 20)


def test_one_picture_is_open_at_a_time(files: list[Path], tmp_path: Path) -> None:
    asked: list[int] = []

    def ask(n: int) -> Path:
        asked.append(n)
        # all but the first, to which Pillow winds back, are gone as soon as the next is asked for
        if n > 1:
            files[n - 1].unlink()
        return files[n]

    write_webp(tmp_path / "film.webp", range(7), ask, fps=24.0, scale=1.0, quality=80)
    assert asked == [*range(7), 0]


PNG, SMALL = b"\x89PNG\r\n\x1a\n", picture(0, (30, 60))
BROKEN: list[tuple[str, Callable[[Path], object]]] = [
    (r"4\.png: the file is empty", lambda path: path.write_bytes(b"")),
    (r"4\.png: (the file )?cannot be read as a picture", lambda path: path.write_bytes(b"not a picture")),
    (r"4\.png: (the file )?cannot be read as a picture", lambda path: path.write_bytes(PNG)),
    (r"4\.png", lambda path: path.write_bytes(path.read_bytes()[:-60])),
    (r"4\.png", lambda path: path.unlink()),
    (r"frame 4: not of the size of the first", lambda path: write_png(path, SMALL)),
]


@pytest.mark.parametrize(("message", "spoil"), BROKEN)
def test_broken_pictures_of_a_film_are_named(files: list[Path], tmp_path: Path, message: str, spoil: Callable) -> None:
    spoil(files[4])
    with pytest.raises(BadInput, match=message):
        write(files, tmp_path / "film.webp")
    with pytest.raises(BadInput, match="no pictures"):
        write([], tmp_path / "film.webp")


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


GREY = np.array([[0, 51, 255], [102, 204, 1]], np.uint8)


def saved(folder, array, name="paint.png", mode=None):
    path = folder / name
    image = Image.fromarray(array)
    (image if mode is None else image.convert(mode)).save(path)
    return path


DEEP = np.array([[0, 1, 65535], [32768, 257, 1000]], np.uint16)


@pytest.mark.parametrize(
    ("picture", "mode", "values"),
    [(GREY, mode, GREY / 255) for mode in ("L", "RGB", "RGBA", "LA", "P")]
    + [(DEEP, None, DEEP / 65535), (GREY > 100, None, GREY > 100)],
)
def test_values_are_shares_of_white_for_any_mode_and_depth(tmp_path, picture, mode, values):
    found = read_image(saved(tmp_path, picture, mode=mode))
    assert found.dtype == np.float64 and np.allclose(found, values, atol=1e-9)


def test_floats_are_taken_as_they_are(tmp_path):
    path = saved(tmp_path, np.array([[0.0, 0.25], [1.0, 0.123]], np.float32), "paint.tif")
    assert np.allclose(read_image(path), [[0.0, 0.25], [1.0, 0.123]])
    for wild in (1.5, -0.1, np.nan, np.inf):
        with pytest.raises(BadInput, match="below black or above white"):
            read_image(saved(tmp_path, np.array([[0.5, wild]], np.float32), "paint.tif"))


def noise(path: Path) -> None:
    saved(path.parent, np.random.default_rng(0).integers(0, 255, (64, 64)).astype(np.uint8))
    path.write_bytes(path.read_bytes()[:2000])


@pytest.mark.parametrize(
    ("message", "spoil"),
    [
        (r"paint.png: the file is empty", lambda path: path.write_bytes(b"")),
        (r"paint.png: not an image \(a PNG", lambda path: path.write_bytes(b"length,radius\r\n1,2\r\n")),
        (r"paint.png: not an image \(a PNG", lambda path: path.write_bytes(bytes(range(256)))),
        ("cannot be read: No such file", lambda path: None),
        ("cannot be read: it is a directory", lambda path: path.mkdir()),
        ("cannot be read|broken", noise),
    ],
)
def test_invalid_images_are_refused(tmp_path, message, spoil):
    spoil(tmp_path / "paint.png")
    with pytest.raises(BadInput, match=message):
        read_image(tmp_path / "paint.png")


def test_a_header_that_promises_too_many_pixels_is_refused_before_they_are_made(tmp_path):
    path = saved(tmp_path, GREY)
    data = bytearray(path.read_bytes())
    for size in (11_000, 60_000):
        data[16:24] = size.to_bytes(4, "big") * 2
        data[29:33] = zlib.crc32(data[12:29]).to_bytes(4, "big")
        path.write_bytes(data)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(BadInput, match=r"broken: .*decompression bomb"):
                read_image(path)
