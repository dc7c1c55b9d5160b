"""Strands of AMD TressFX files (.tfx, version 4.0), little-endian.

byte 0 float32 version | 4 uint32 strands | 8 uint32 points a strand | 12 uint32 where the positions begin |
16..31 uint32 where other values begin | 32..159 reserved | then float32[4] for every point: x, y, z, inverse mass.
"""

import struct
from pathlib import Path
from typing import Literal

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.plain_file import content

HEADER = struct.Struct("<f3I")
SIZE_OF_HEADER, SIZE_OF_POINT = 160, 16
VERSION = 4.0


def read_tfx(path: Path, unit: float = 1.0, up: Literal["y", "z"] = "y") -> tuple[np.ndarray, np.ndarray]:
    """Return the points of all strands, root first [m], Y up, (p, 3) float64, and their offsets, (S+1,) int32.

    unit  of the file's coordinates, which it does not say [m]
    up    axis of the file
    Raise BadInput where the file cannot be read, its header contradicts its size, or a position is not finite.
    """
    data = content(path, "a .tfx file")
    strands, count, start = read_header(data, path)
    size = strands * count
    table = np.frombuffer(data, "<f4", 4 * size, start).reshape(size, 4)
    bad = np.flatnonzero(~np.isfinite(table[:, :3]).all(axis=1))
    if len(bad):
        where = f"{path}, byte {start + SIZE_OF_POINT * bad[0]}, strand {bad[0] // count}, point {bad[0] % count}"
        raise BadInput("a position is not finite", where=where, right="finite coordinates")
    x, y, z = table[:, :3].astype(np.float64).T * unit
    points = np.stack((x, y, z) if up == "y" else (x, z, -y), axis=1)
    return points, np.arange(strands + 1, dtype=np.int32) * np.int32(count)


def read_header(data: bytes, path: Path) -> tuple[int, int, int]:
    """Return how many strands there are, points in each, and the byte where they begin; checked against the size."""
    if len(data) < SIZE_OF_HEADER:
        raise BadInput(f"the file has {len(data)} bytes", where=path, right=f"a header of {SIZE_OF_HEADER} bytes")
    version, strands, count, start = HEADER.unpack_from(data)
    if version != VERSION:
        raise BadInput(f"version {version:g}", where=f"{path}, byte 0", right="TressFX version 4.0")
    if strands < 1:
        raise BadInput("no strands", where=f"{path}, byte 4", right="at least 1")
    if count < 2:
        raise BadInput(f"{count} points a strand", where=f"{path}, byte 8", right="at least 2")
    if start < SIZE_OF_HEADER:
        raise BadInput(f"positions begin at byte {start}", where=f"{path}, byte 12", right=f"{SIZE_OF_HEADER} or more")
    needed = start + SIZE_OF_POINT * strands * count
    if len(data) < needed:
        what = f"{strands} strands of {count} points need {needed} bytes, the file has {len(data)}"
        raise BadInput(what, where=f"{path}, byte 4", right="a whole file")
    return strands, count, start
