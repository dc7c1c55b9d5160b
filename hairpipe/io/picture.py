"""Pictures as PNG, and animations as WebP."""

import io
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from hairpipe.errors import BadInput
from hairpipe.plain_file import checked_size

EFFORT = 4
"""Effort of the WebP encoder, 0 to 6: higher is slower and gives smaller files."""


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write a picture, (height, width, 3) uint8, sRGB; equal pictures give equal bytes."""
    Image.fromarray(picture).save(path, "PNG")


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
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
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
        """Return the selected frame, counted from 0."""
        return self._frame


def read_picture(path: Path) -> Image.Image:
    """Read a picture of any format of Pillow as RGB; BadInput for a damaged or another file."""
    checked_size(path, "a whole PNG file")
    try:
        with Image.open(path) as image:
            return image.convert("RGB")
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise BadInput(f"cannot be read as a picture: {error}", where=path, right="a whole PNG file") from error
