"""Strands one after the other, little-endian: USC-HairSalon (.data), and reconstructions such as CT2Hair (.bin).

Both:   int32 strands, then for each strand int32 points and its points
.data:  float32[3] a point
.bin:   float32[7] a point: place, direction, label
"""

import warnings
from pathlib import Path

import numpy as np

from hairpipe.data.curves import Curves
from hairpipe.errors import BadInput
from hairpipe.io.strands.plain import Up, plain_curves
from hairpipe.plain_file import content

NUMBERS = {".data": 3, ".bin": 7}
"""Numbers of a point, by suffix."""


def read_records(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the strands that have points.

    unit  unit of the file's coordinates, which the file does not state [m]
    up    axis of the file
    Raises BadInput, with the byte, where a number of strands or points contradicts the size of the file; warns of
    strands without points, and of directions and labels, which are not read.
    """
    words = np.frombuffer(whole_words(content(path, f"a {path.suffix} file")), "<i4")
    width = NUMBERS[path.suffix.lower()]
    strands = int(words[0])
    if not 1 <= strands < len(words):
        right = f"1 to {len(words) - 1}, for a file of {4 * len(words)} bytes"
        raise BadInput(f"{strands} strands", where=f"{path}, byte 0", right=right)
    counts = np.empty(strands, np.int64)
    at = 1
    for s in range(strands):
        count = int(words[at]) if at < len(words) else -1
        left = (len(words) - at - 1) // width
        if not 0 <= count <= left:
            what = f"strand {s} has {count} points" if at < len(words) else f"strand {s} of {strands} is missing"
            right = f"0 to {left}: the file has no more" if left >= 0 else "a whole file"
            raise BadInput(what, where=f"{path}, byte {4 * at}", right=right)
        counts[s] = count
        at += 1 + width * count
    if at < len(words):
        raise BadInput(
            f"{4 * (len(words) - at)} bytes follow the last strand", where=f"{path}, byte {4 * at}", right="none"
        )
    heads = np.cumsum(1 + width * counts) - width * counts
    numbers = np.delete(words[1:], heads - 1).view("<f4").reshape(-1, width)
    if not counts.all():
        warnings.warn(f"{path}: {(counts == 0).sum()} strands have no points and are left out", stacklevel=2)
    if width > 3:
        warnings.warn(f"{path}: directions and labels are not read", stacklevel=2)
    return plain_curves(numbers[:, :3], counts[counts > 0], unit, up)


def whole_words(data: bytes) -> bytes:
    """Return data without the last bytes that are not a whole number of 4 bytes; at least one number."""
    return data[: len(data) // 4 * 4] or bytes(4)
