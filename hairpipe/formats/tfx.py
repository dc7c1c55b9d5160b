"""Strands of AMD TressFX files (.tfx), little-endian, of versions 3 and 4 of the binary format.

Both:      byte 0 float32 version | 4 uint32 strands | 8 uint32 points a strand
Version 4: 12 uint32 where the positions begin | .. 159 header | float32[4] for every point: x, y, z, inverse mass
Version 3: 16 uint32 not 0 where both ends of strands are held | 144 uint32 where the positions begin | .. 295 header |
           float32[3] for every point

In version 4 an end is held whose inverse mass is 0. Thickness, colours and texture coordinates are not read: TressFX
gives the first no unit, and roots have those of the body.
"""

import struct
import warnings
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.polylines import Up, plain_curves
from hairpipe.plain_file import content
from hairpipe.values.groom import Curves

START = struct.Struct("<f2I")


class Format(NamedTuple):
    """Layout of a version of the format.

    header  size of the header [bytes]
    begin   byte of the offset of the positions
    width   numbers per point
    """

    header: int
    begin: int
    width: int


FORMATS = {3.0: Format(296, 144, 3), 4.0: Format(160, 12, 4)}
BOTH_ENDS = 16
UNREAD = {"coordinates of strands": 16, "coordinates of points": 20, "thickness": 24, "colours": 28}
"""Arrays of version 4, and the byte of the offset of each, which is 0 for an absent array."""


def read_tfx(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the strands, root first, Y up, numbered by their order."""
    data = content(path, "a .tfx file")
    form, strands, count, start = read_header(data, path)
    table = np.frombuffer(data, "<f4", form.width * strands * count, start).reshape(-1, form.width)
    found = [name for name, byte in UNREAD.items() if struct.unpack_from("<I", data, byte)[0]]
    if form == FORMATS[4.0] and found:
        warnings.warn(f"{path}: arrays that are not read: {', '.join(found)}", stacklevel=2)
    if form.width == 4:
        free = table[:, 3].reshape(strands, count) != 0.0
        held = ~free[:, -1] & free.any(axis=1)
    else:
        held = np.full(strands, struct.unpack_from("<I", data, BOTH_ENDS)[0] != 0)
    return replace(plain_curves(table[:, :3], np.full(strands, count), unit, up), held=held)


def read_header(data: bytes, path: Path) -> tuple[Format, int, int, int]:
    """Return the format, the number of strands, points of each, and the byte where these begin; all checked."""
    if len(data) < START.size:
        raise BadInput(f"the file has {len(data)} bytes", where=path, right="the header of a .tfx file")
    version, strands, count = START.unpack_from(data)
    form = FORMATS.get(version)
    if form is None:
        raise BadInput(f"version {version:g}", where=f"{path}, byte 0", right="binary TressFX of version 3.0 or 4.0")
    if len(data) < form.header:
        raise BadInput(f"the file has {len(data)} bytes", where=path, right=f"a header of {form.header} bytes")
    (start,) = struct.unpack_from("<I", data, form.begin)
    if strands < 1:
        raise BadInput("no strands", where=f"{path}, byte 4", right="at least 1")
    if count < 2:
        raise BadInput(f"{count} points a strand", where=f"{path}, byte 8", right="at least 2")
    if start < form.header:
        where = f"{path}, byte {form.begin}"
        raise BadInput(f"positions begin at byte {start}", where=where, right=f"{form.header} or more")
    needed = start + 4 * form.width * strands * count
    if len(data) < needed:
        what = f"{strands} strands of {count} points need {needed} bytes, the file has {len(data)}"
        raise BadInput(what, where=f"{path}, byte 4", right="a whole file")
    return form, strands, count, start
