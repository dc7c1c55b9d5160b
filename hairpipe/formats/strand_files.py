"""Strands of a file of any supported format, by its suffix.

Strands one after the other, little-endian: USC-HairSalon (.data), and reconstructions such as CT2Hair (.bin).

Both:   int32 strands, then for each strand int32 points and its points
.data:  float32[3] a point
.bin:   float32[7] a point: place, direction, label
"""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.formats.bodies import USD_SUFFIXES
from hairpipe.formats.polylines import Up, plain_curves
from hairpipe.plain_file import Absent, content
from hairpipe.values.groom import Curves

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


PLAIN = (".abc", ".hair", ".data", ".bin", ".ply", ".obj", ".tfx")
"""Suffixes of files that state neither unit nor axis."""
SUFFIXES = (*USD_SUFFIXES, *PLAIN)
GivenUp = Literal["y", "z"]


def read_strands(
    path: Path, unit: float, up: GivenUp, time: float | None, guides: bool = False, absent: Absent = "refuse"
) -> Curves:
    """Return the strands of a file, in metres with Y up.

    unit, up  unit [m] and axis of a file that states neither
    time      time code of a file with samples
    guides    whether curves of purpose guide are read in any case
    absent    whether absent files of a stage are refused, or warned of

    Raises BadInput, with the place, where the file cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix in USD_SUFFIXES:
        from hairpipe.formats.usd.meshes import read_curves

        return read_curves(path, time=time, guides=guides, absent=absent)
    if suffix not in PLAIN:
        right = f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        raise BadInput(f"hair is not read from {suffix or 'such'} files", where=path, right=right)
    return work_apart(plain_reader(suffix), path, unit, up)


def plain_reader(suffix: str) -> Callable[[Path, float, GivenUp], Curves]:
    """Return the reader of a file that states neither unit nor axis; imports only this one."""
    if suffix == ".tfx":
        from hairpipe.formats.tfx import read_tfx

        return read_tfx
    if suffix == ".abc":
        from hairpipe.formats.alembic_curves import read_alembic

        return read_alembic
    if suffix == ".hair":
        from hairpipe.formats.yuksel import read_hair

        return read_hair
    if suffix in (".data", ".bin"):
        pass

        return read_records
    from hairpipe.formats.polylines import read_obj_strands, read_ply_strands

    return read_ply_strands if suffix == ".ply" else read_obj_strands
