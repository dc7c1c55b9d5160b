"""Strands of HAIR files (.hair) of Cem Yuksel, little-endian.

Header:  0 "HAIR" | 4 uint32 strands | 8 uint32 points | 12 uint32 arrays, a bit each | 16 uint32 segments a strand |
         20 float32 thickness | 24 float32 transparency | 28 float32[3] colour | 40 text | 128 arrays
Arrays:  bit 0 uint16 segments of each strand, bit 1 float32[3] points, bit 2 float32 thickness, bit 3 float32
         transparency, bit 4 float32[3] colour of each point; without an array the value of the header holds

Source: http://www.cemyuksel.com/research/hairmodels
"""

import struct
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.polylines import Up, plain_curves
from hairpipe.plain_file import content
from hairpipe.values.groom import Curves

HEADER = struct.Struct("<4s4I5f88s")
SEGMENTS, POINTS, THICKNESS, TRANSPARENCY, COLOURS = 1, 2, 4, 8, 16
WIDTHS = {POINTS: 3, THICKNESS: 1, TRANSPARENCY: 1, COLOURS: 3}
"""Numbers per point of the arrays after that of segments, in the order of the file."""


class Header(NamedTuple):
    """Header of a file: numbers, and the values of points for which there is no array."""

    signature: bytes
    strands: int
    points: int
    arrays: int
    segments: int
    thickness: float
    transparency: float
    red: float
    green: float
    blue: float
    text: bytes


def read_hair(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the strands with thickness as width, and colours."""
    data = content(path, "a .hair file")
    if len(data) < HEADER.size or data[:4] != b"HAIR":
        raise BadInput("the file does not begin with a header of HAIR", where=f"{path}, byte 0", right="a .hair file")
    head = Header(*HEADER.unpack_from(data))
    strands, count, arrays = head.strands, head.points, head.arrays
    if not strands:
        raise BadInput("no strands", where=f"{path}, byte 4", right="at least 1")
    if not arrays & POINTS or arrays >= 2 * COLOURS:
        raise BadInput(f"arrays are {arrays:#x}", where=f"{path}, byte 12", right="bits 0 to 4, bit 1 (points) set")
    needed = HEADER.size + 2 * strands * (arrays & SEGMENTS)
    sizes = {bit: 4 * width * count for bit, width in WIDTHS.items() if arrays & bit}
    if needed + sum(sizes.values()) > len(data):
        total = needed + sum(sizes.values())
        what = f"{strands} strands of {count} points need {total} bytes, the file has {len(data)}"
        raise BadInput(what, where=f"{path}, byte 4", right="a whole file")
    listed = np.frombuffer(data, "<u2", strands if arrays & SEGMENTS else 0, HEADER.size).astype(np.int64)
    total = int(listed.sum()) + strands if arrays & SEGMENTS else strands * (head.segments + 1)
    if total != count:
        where = f"{path}, byte {HEADER.size if arrays & SEGMENTS else 16}"
        raise BadInput(f"segments give {total} points", where=where, right=f"the number of points, {count}")
    counts = listed + 1 if arrays & SEGMENTS else np.full(strands, head.segments + 1)
    found = dict[int, np.ndarray]()
    for bit, size in sizes.items():
        found[bit] = np.frombuffer(data, "<f4", size // 4, needed)
        needed += size
    if arrays & TRANSPARENCY or head.transparency:
        warnings.warn(f"{path}: transparency is not read", stacklevel=2)
    widths = found.get(THICKNESS, np.full(count, head.thickness) if head.thickness > 0.0 else None)
    bare = np.tile(np.array(head[7:10], np.float32), (count, 1))
    colours = found[COLOURS].reshape(-1, 3) if COLOURS in found else bare
    return plain_curves(found[POINTS].reshape(-1, 3), counts, unit, up, widths=widths, colours=colours)
