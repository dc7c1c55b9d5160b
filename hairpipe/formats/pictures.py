"""Pictures as PNG, animations as WebP, images of painted values, and sheets of pictures with captions."""

import io
import warnings
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont, UnidentifiedImageError

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.plain_file import checked_size

EFFORT = 4
"""Effort of the WebP encoder, 0 to 6: higher is slower and gives smaller files."""
DAMAGED = (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError)


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write a picture, (height, width, 3) uint8, sRGB; equal pictures give equal bytes."""
    Image.fromarray(picture).save(path, "PNG", compress_level=2)  # a third of the time of 6, files 17 % larger


def write_webp(
    path: Path, frames: Sequence[int], picture: Callable[[int], Path], *, fps: float, scale: float, quality: int
) -> None:
    """Write an endless animation at the speed of the shot, with one picture in memory at a time.

    Where frames are omitted, a picture is shown until the next one; the last one as long as the shortest.

    WebP is played by every browser in full colour: the 256 colours of GIF show bands on a soft backdrop, and lossless
    APNG is ten times as large.

    frames   their numbers, ascending
    picture  file of a frame, all of one size; BadInput names the first that is not a picture or has another size
    fps      frames of the shot per second [1/s]
    scale    size of the animation over that of the pictures
    quality  0..100 of the lossy compression
    """
    if not frames:
        raise BadInput("no pictures to show", right="at least one frame")
    shortest = min((after - before for before, after in pairwise(frames)), default=1)
    moments = [round(1000.0 * (n - frames[0]) / fps) for n in (*frames, frames[-1] + shortest)]
    durations = [max(1, after - before) for before, after in pairwise(moments)]
    reel = Reel(frames, picture, scale)
    reel.save(path, "WEBP", save_all=True, duration=durations, loop=0, quality=quality, method=EFFORT)


def reduced(data: bytes, quality: int) -> bytes:
    """Return a picture as lossy WebP of a quality 0..100; a WebP file, perhaps an animation, unchanged.

    BadInput where it is not a picture.
    """
    try:
        with Image.open(io.BytesIO(data)) as image:
            if image.format == "WEBP":
                return data
            written = io.BytesIO()
            image.convert("RGB").save(written, "WEBP", quality=quality, method=EFFORT)
            return written.getvalue()
    except DAMAGED as error:
        raise BadInput(f"cannot be read as a picture: {error}", right="a PNG, JPEG or WebP") from error


class Reel(Image.Image):
    """An image of many frames that reads the file of a frame at `seek`, which Pillow's encoders call in order."""

    def __init__(self, frames: Sequence[int], picture: Callable[[int], Path], scale: float) -> None:
        super().__init__()
        self.n_frames = len(frames)
        self._numbers, self._picture, self._scale = frames, picture, scale
        self._frame = -1
        self.seek(0)

    def seek(self, frame: int) -> None:
        """Select a frame, counted from 0."""
        if frame == self._frame:
            return
        image = read_picture(self._picture(self._numbers[frame]))
        size = (max(1, round(image.width * self._scale)), max(1, round(image.height * self._scale)))
        if frame > 0 and size != self._size:
            where = f"frame {self._numbers[frame]}"
            right = f"{self.width} x {self.height} pixels"
            raise BadInput("not of the size of the first", where=where, right=right)
        shown = image.resize(size, Image.Resampling.LANCZOS) if size != image.size else image
        self.im = shown.im
        self._mode = shown.mode
        self._size = size
        self._frame = frame

    def tell(self) -> int:
        return self._frame


def read_picture(path: Path) -> Image.Image:
    """Read a picture of any format of Pillow as RGB; BadInput for a damaged or another file."""
    checked_size(path, "a whole PNG file")
    try:
        with Image.open(path) as image:
            return image.convert("RGB")
    except DAMAGED as error:
        raise BadInput(f"cannot be read as a picture: {error}", where=path, right="a whole PNG file") from error


FORMATS = "a PNG, TIFF, JPEG or another picture that Pillow reads"
EIGHT_BITS, SIXTEEN_BITS = 255.0, 65535.0


def read_image(path: Path) -> np.ndarray:
    """Return an image as values 0..1, (height, width) float64, the top row first, decoded in a child process."""
    return work_apart(decode_image, path)


def decode_image(path: Path) -> np.ndarray:
    """Return values 0..1, over the largest of the file without gamma, since paint is not light; of colours the luma."""
    checked_size(path, FORMATS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            warnings.simplefilter("ignore", UserWarning)  # of metadata, and of transparency, which are not used
            with Image.open(path) as image:
                most = 1.0 if image.mode == "F" else SIXTEEN_BITS if image.mode.startswith("I") else EIGHT_BITS
                values = np.asarray(image.convert("L") if most == EIGHT_BITS else image, np.float64) / most
    except UnidentifiedImageError:
        raise BadInput("not an image", where=path, right=FORMATS) from None
    except OSError as error:
        raise BadInput(f"the image cannot be read: {error.strerror or error}", where=path, right=FORMATS) from None
    except Exception as error:  # decoders raise any exception for broken files
        raise BadInput(f"the image is broken: {error}", where=path, right=FORMATS) from None
    if not (np.isfinite(values).all() and values.min() >= 0.0 and values.max() <= 1.0):
        raise BadInput("the image has values below black or above white", where=path, right="values 0..1")
    return values


def encoded_image(values: np.ndarray) -> bytes:
    """Return values (height, width) uint8 as a PNG file, the top row first; pure."""
    stream = io.BytesIO()
    Image.fromarray(values).save(stream, "PNG", optimize=True)
    return stream.getvalue()


INK, PAPER = (255, 255, 255), (20, 22, 26)
GAP = 4
"""Between two pictures [pixels]."""


def check_names(names: Sequence[str], count: int) -> None:
    """Raise BadInput for more names than pictures."""
    if len(names) > count:
        raise BadInput(f"{len(names)} for {count} to be named", where="names", right=f"{count} or fewer")


def write_side_by_side(path: Path, pictures: Sequence[np.ndarray], words: Sequence[str], corner: str) -> None:
    """Write a PNG of pictures of one size, (height, width, 3) uint8 each, with a caption over each.

    words   captions, one for each, or none; corner  text in the corner of the first
    """
    height, width = pictures[0].shape[:2]
    sheet = Image.new("RGB", (len(pictures) * (width + GAP) - GAP, height), PAPER)
    for place, picture in enumerate(pictures):
        sheet.paste(Image.fromarray(picture), (place * (width + GAP), 0))
    pen = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(max(10, height // 18))
    for place, word in enumerate(words):
        pen.text((place * (width + GAP) + 0.5 * width, height * 0.02), word, INK, font, anchor="ma")
    pen.text((height * 0.03, height * 0.97), corner, INK, font, anchor="ls")
    sheet.save(path, "PNG")


def write_below(
    path: Path,
    pictures: Mapping[str, Path | None],
    columns: int,
    words: Mapping[int, str] = {},
    corners: Sequence[str] = ("",),
) -> None:
    """Write a PNG of pictures, by their names in messages, all of the size of the first, in rows of so many.

    pictures at least one; a place without one is empty
    words    over places, by their numbers; corners  words in the corners of all, over and over
    Raise BadInput naming a picture of another size.
    """
    images = [picture and read_picture(picture) for picture in pictures.values()]
    width, height = next(image.size for image in images if image)
    for name, image in zip(pictures, images, strict=True):
        if image and image.size != (width, height):
            right = f"{width} x {height} as the first"
            raise BadInput(f"{image.width} x {image.height} pixels", where=name, right=right)
    rows = -(-len(images) // columns)
    columns = min(columns, len(images))
    sheet = Image.new("RGB", (columns * (width + GAP) - GAP, rows * (height + GAP) - GAP), PAPER)
    pen = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(max(10, height // 22))
    for place, image in enumerate(images):
        left = place % columns * (width + GAP)
        top = place // columns * (height + GAP)
        if image:
            sheet.paste(image, (left, top))
        at = (left + height * 0.03, top + height * 0.02)
        edge = {"stroke_width": 2, "stroke_fill": PAPER}
        pen.text(at, words.get(place, ""), INK, font, **edge)
        corner = (left + height * 0.03, top + height * 0.98)
        pen.text(corner, corners[place % len(corners)], INK, font, anchor="ls", **edge)
    sheet.save(path, "PNG")
