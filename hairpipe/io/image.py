"""Images of painted values."""

import warnings
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.plain_file import checked_size

FORMATS = "a PNG, TIFF, JPEG or another picture that Pillow reads"
EIGHT_BITS, SIXTEEN_BITS = 255.0, 65535.0


def read_image(path: Path) -> np.ndarray:
    """Return an image as values 0..1, (height, width) float64, the top row first, decoded in a child process."""
    return work_apart(decode_image, path)


def decode_image(path: Path) -> np.ndarray:
    """Return an image as values 0..1, (height, width) float64, the top row first; of colours the luma, alpha ignored.

    Values are those of the file over the largest possible one: paint is a number, not light, so that gamma is kept.
    Raise BadInput where the file cannot be read, is not an image, is broken, or has more pixels than Pillow allows.
    """
    checked_size(path, FORMATS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            warnings.simplefilter("ignore", UserWarning)  # of metadata, and of transparency, which are not used
            with Image.open(path) as image:
                values = pixel_values(image)
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
    stream = BytesIO()
    Image.fromarray(values).save(stream, "PNG", optimize=True)
    return stream.getvalue()


def pixel_values(image: Image.Image) -> np.ndarray:
    """Return the pixels of an opened image as values, (height, width) float64."""
    if image.mode == "F":
        return np.asarray(image, np.float64)
    if image.mode.startswith("I"):
        return np.asarray(image, np.float64) / SIXTEEN_BITS
    return np.asarray(image.convert("L"), np.float64) / EIGHT_BITS
