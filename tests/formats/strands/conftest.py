"""Five strands of different lengths, as bytes of each format, written from its description."""

import struct

import numpy as np
import pytest

COUNTS = (4, 2, 7, 3, 5)


@pytest.fixture
def strands() -> list[np.ndarray]:
    generator = np.random.default_rng(3)
    return [np.float32(np.cumsum(generator.uniform(0.01, 0.1, (count, 3)), axis=0)) for count in COUNTS]


@pytest.fixture
def hair_bytes(strands):
    """A HAIR file with all arrays: thickness 0.001 k, colours k / 32 of point k."""

    def write(arrays: int = 23, count: int | None = None, total: int | None = None) -> bytes:
        points = np.concatenate(strands)
        places = np.arange(len(points), dtype="<f4")
        header = b"HAIR" + struct.pack(
            "<4I5f", count or len(strands), total or len(points), arrays, 3, 0.5, 0.0, 0.25, 0.5, 0.75
        )
        parts = {
            1: np.array(COUNTS, "<u2") - np.uint16(1),
            2: points.astype("<f4"),
            4: places * np.float32(0.001),
            8: places * np.float32(0.0),
            16: np.repeat(places / np.float32(32), 3),
        }
        return (header + bytes(88)) + b"".join(part.tobytes() for bit, part in parts.items() if arrays & bit)

    return write


@pytest.fixture
def record_bytes(strands):
    def write(width: int) -> bytes:
        rows = [np.hstack([s, np.full((len(s), width - 3), 9.0)]).astype("<f4") for s in strands]
        return struct.pack("<i", len(rows)) + b"".join(struct.pack("<i", len(row)) + row.tobytes() for row in rows)

    return write
