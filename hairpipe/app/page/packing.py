"""Arrays as compact text that a browser unpacks without a library: differences, byte planes, deflate, base64.

A page opened from a file may not fetch, but it may load scripts: every document is a script that calls `hairpipe.load`
with a name, a plain value and this text.
"""

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

EFFORT, QUICK, LARGE = 9, 1, 4_000_000
"""Levels of deflate, 1 to 9: the slowest saves a tenth of the bytes; the quick one is for arrays of so many bytes."""
STEPS = 16383
"""Bits of a quantised coordinate: 14 bits are 30 um in half a metre, less than the thickness of a hair."""

Packed = tuple[dict[str, Any], bytes]
"""Meta data for unpacking, and the bytes before base64."""


def quantised(points: np.ndarray) -> tuple[np.ndarray, dict[str, Any]]:
    """Return points (n, 3) as whole steps (n, 3) int64 of their box, and the box: `low` and `step` [m]. Pure.

    The error is at most half a step: 16383 of them span the longest side of the box.
    """
    if not len(points):
        return np.zeros((0, 3), np.int64), {"low": [0.0, 0.0, 0.0], "step": 1.0}
    low = points.min(axis=0)
    step = float((points - low).max()) / STEPS or 1.0
    return np.rint((points - low) / step).astype(np.int64), {"low": low.tolist(), "step": step}


def second_differences(values: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the first value of every strand, the first difference, then second differences, (p, 3); pure.

    These are small for smooth strands.

    values   (p, 3) int64
    offsets  strand s owns values offsets[s]:offsets[s+1], (S+1,)
    """
    lengths = np.diff(offsets)
    begins = offsets[:-1][lengths > 0]
    followers = offsets[:-1][lengths > 1] + 1
    first = np.diff(values, axis=0, prepend=0)
    second = np.diff(first, axis=0, prepend=0)
    second[begins], second[followers] = values[begins], first[followers]
    return second


def zigzag(values: np.ndarray) -> np.ndarray:
    """Return signed differences modulo 2^16 as (n, 3) uint16, small for small ones of either sign; pure."""
    wrapped = values.astype(np.int16)
    return ((wrapped << 1) ^ (wrapped >> 15)).view(np.uint16)


def pack(arrays: Mapping[str, np.ndarray], **meta: Any) -> Packed:
    """Pack arrays of uint8, uint16 or uint32, column by column and byte by byte, with plain values added; pure."""
    places, planes = [], []
    for name, array in arrays.items():
        flat = np.ascontiguousarray(array.T if array.ndim == 2 else array).ravel()
        size = flat.dtype.itemsize
        bytewise = flat.view(np.uint8).reshape(-1, size).T
        places.append({"name": name, "bytes": size, "shape": list(array.shape)})
        planes.append(bytewise.tobytes())
    joined = b"".join(planes)
    return {**meta, "arrays": places}, zlib.compress(joined, EFFORT if len(joined) < LARGE else QUICK)


def script(name: str, document: Any, packed: bytes = b"") -> str:
    """Write a document as a script; texts are escaped, so that they cannot end the script element."""
    return f'hairpipe.load({literal(name)},{literal(document)},"{base64.b64encode(packed).decode()}");\n'


def literal(value: Any) -> str:
    """Write a plain value as a literal for a script element; ValueError for NaN and infinity."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")
