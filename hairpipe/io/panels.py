"""Pictures side by side and below each other, each with a caption."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from hairpipe.errors import BadInput
from hairpipe.io.picture import read_picture

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
