"""What is packed is what a browser unpacks: here the same in Python."""

import base64
import json
import re
import zlib

import numpy as np
import pytest

from hairpipe.app.page.values import STEPS, pack, quantised, script, second_differences, strands_document, zigzag
from hairpipe.values import Strands

RANDOM = np.random.default_rng(3)


def unpacked(document, packed):
    """Undo `pack` by its definition: byte planes of columns."""
    data, arrays = zlib.decompress(packed), {}
    for place in document["arrays"]:
        count, size = int(np.prod(place["shape"])), place["bytes"]
        planes = np.frombuffer(data[: count * size], np.uint8).reshape(size, count)
        data = data[count * size :]
        values = sum(plane.astype(np.int64) << (8 * k) for k, plane in enumerate(planes))
        arrays[place["name"]] = values.reshape(place["shape"][::-1]).T
    assert not data
    return arrays


def restored(codes, lengths):
    """Undo zigzag and second differences, strand by strand, in the arithmetic of whole numbers."""
    signed = np.where(codes % 2, -((codes + 1) // 2), codes // 2)
    parts, begin = [], 0
    for length in lengths:
        own = signed[begin : begin + length].copy()
        own[1:] = np.cumsum(own[1:], axis=0)
        parts.append(np.cumsum(own, axis=0) % (1 << 16))
        begin += length
    return np.concatenate(parts)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
def test_arrays_are_read_back(kind):
    arrays = {"a": RANDOM.integers(0, np.iinfo(kind).max, (7, 3)).astype(kind), "b": np.arange(5, dtype=kind)}
    found = unpacked(*pack(arrays))
    assert all(np.array_equal(found[name], array) for name, array in arrays.items())


def test_places_are_off_by_half_a_step_at_most():
    lengths = np.array([1, 2, 3, 30, 1])
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    points = RANDOM.normal(size=(37, 3)) * [1.0, 30.0, 0.01] + [500.0, 0.0, 0.0]
    steps, box = quantised(points)
    assert box["step"] == pytest.approx(np.ptp(points, axis=0).max() / STEPS)
    back = restored(zigzag(second_differences(steps, offsets)).astype(np.int64), lengths)
    assert np.abs(np.array(box["low"]) + box["step"] * back - points).max() <= 0.5001 * box["step"]


def test_strands_are_taken_evenly_and_keep_their_numbers():
    points = RANDOM.normal(size=(50, 3))
    hair = Strands(points, np.ones((50, 3), np.float32), np.arange(0, 51, 5, dtype=np.int32), 8e-5)
    document, packed = strands_document(hair, 4)
    found = unpacked(document, packed)
    assert document["total"] == 10 and list(found["strands"]) == [0, 3, 6, 9] and list(found["lengths"]) == [5] * 4
    back = np.array(document["low"]) + document["step"] * restored(found["points"], found["lengths"])
    assert np.allclose(back[5:10], points[15:20], atol=document["step"])
    assert document["fastest"] == pytest.approx(np.sqrt(3.0)) and found["speeds"][0] == 255


def test_nothing_in_a_script_ends_it_or_is_code():
    text = script('a"</script>', {"x": "</script><script>alert(1)</script>\u2028"}, b"data")
    assert "<" not in text and "\u2028" not in text
    name, rest = re.fullmatch(r'hairpipe\.load\(("a[^,]*"),(.*)\);\n', text).groups()
    assert json.loads(name) == 'a"</script>'
    assert base64.b64decode(json.loads(rest[rest.rindex(',"') + 1 :])) == b"data"
