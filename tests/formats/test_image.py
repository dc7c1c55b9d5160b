"""Images that carry paint."""

import warnings
import zlib

import numpy as np
import pytest
from PIL import Image

from hairpipe.errors import BadInput
from hairpipe.formats.pictures import read_image

GREY = np.array([[0, 51, 255], [102, 204, 1]], np.uint8)


def saved(folder, array, name="paint.png", mode=None):
    path = folder / name
    image = Image.fromarray(array)
    (image if mode is None else image.convert(mode)).save(path)
    return path


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "LA", "P"])
def test_grey_is_the_value_over_white_for_any_mode(tmp_path, mode):
    values = read_image(saved(tmp_path, GREY, mode=mode))
    assert values.dtype == np.float64 and np.allclose(values, GREY / 255)


def test_sixteen_bits_are_kept(tmp_path):
    deep = np.array([[0, 1, 65535], [32768, 257, 1000]], np.uint16)
    assert np.allclose(read_image(saved(tmp_path, deep)), deep / 65535, atol=1e-9)


def test_floats_are_taken_as_they_are(tmp_path):
    path = saved(tmp_path, np.array([[0.0, 0.25], [1.0, 0.123]], np.float32), "paint.tif")
    assert np.allclose(read_image(path), [[0.0, 0.25], [1.0, 0.123]])
    for wild in (1.5, -0.1, np.nan, np.inf):
        with pytest.raises(BadInput, match="below black or above white"):
            read_image(saved(tmp_path, np.array([[0.5, wild]], np.float32), "paint.tif"))


def test_black_and_white_pictures_are_zero_and_one(tmp_path):
    assert np.array_equal(read_image(saved(tmp_path, GREY > 100, "paint.png")), GREY > 100)


def test_invalid_images_are_refused(tmp_path):
    text = tmp_path / "paint.png"
    text.write_bytes(b"")
    with pytest.raises(BadInput, match=r"paint.png: the file is empty"):
        read_image(text)
    for content in (b"length,radius\r\n1,2\r\n", bytes(range(256))):
        text.write_bytes(content)
        with pytest.raises(BadInput, match=r"paint.png: not an image \(a PNG"):
            read_image(text)
    with pytest.raises(BadInput, match="cannot be read: No such file"):
        read_image(tmp_path / "none.png")
    with pytest.raises(BadInput, match="cannot be read: it is a directory"):
        read_image(tmp_path)


def test_truncated_image_is_reported(tmp_path):
    path = saved(tmp_path, np.random.default_rng(0).integers(0, 255, (64, 64)).astype(np.uint8))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(BadInput, match=r"cannot be read|broken"):
        read_image(path)


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
