"""Pictures read back as they were written, and films last as long as they should."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.errors import BadInput
from hairpipe.formats.pictures import write_png, write_webp


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


@pytest.mark.parametrize("content", [b"", b"not a picture", b"\x89PNG\r\n\x1a\n"])
def test_a_damaged_picture_is_named(files: list[Path], tmp_path: Path, content: bytes) -> None:
    files[4].write_bytes(content)
    with pytest.raises(BadInput, match=r"4\.png: (the file is empty|cannot be read as a picture)"):
        write(files, tmp_path / "film.webp")


def test_a_cut_picture_is_named(files: list[Path], tmp_path: Path) -> None:
    files[4].write_bytes(files[4].read_bytes()[:-60])
    with pytest.raises(BadInput, match=r"4\.png"):
        write(files, tmp_path / "film.webp")


def test_a_missing_picture_is_named(files: list[Path], tmp_path: Path) -> None:
    files[2].unlink()
    with pytest.raises(BadInput, match=r"2\.png"):
        write(files, tmp_path / "film.webp")


def test_pictures_of_different_sizes_are_refused(files: list[Path], tmp_path: Path) -> None:
    write_png(files[5], picture(0, (30, 60)))
    with pytest.raises(BadInput, match="frame 5: not of the size of the first"):
        write(files, tmp_path / "film.webp")


def test_no_pictures_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no pictures"):
        write([], tmp_path / "film.webp")
