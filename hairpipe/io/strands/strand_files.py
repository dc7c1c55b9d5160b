"""Strands of a file of any supported format, by its suffix."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from hairpipe.apart import work_apart
from hairpipe.data.curves import Curves
from hairpipe.errors import BadInput
from hairpipe.io.body import USD_SUFFIXES
from hairpipe.plain_file import Absent

PLAIN = (".abc", ".hair", ".data", ".bin", ".ply", ".obj", ".tfx")
"""Suffixes of files that state neither unit nor axis."""
SUFFIXES = (*USD_SUFFIXES, *PLAIN)
Up = Literal["y", "z"]


def read_strands(
    path: Path, unit: float, up: Up, time: float | None, guides: bool = False, absent: Absent = "refuse"
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
        from hairpipe.io.usd.read import read_curves

        return read_curves(path, time=time, guides=guides, absent=absent)
    if suffix not in PLAIN:
        right = f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        raise BadInput(f"hair is not read from {suffix or 'such'} files", where=path, right=right)
    return work_apart(plain_reader(suffix), path, unit, up)


def plain_reader(suffix: str) -> Callable[[Path, float, Up], Curves]:
    """Return the reader of a file that states neither unit nor axis; imports only this one."""
    if suffix == ".tfx":
        from hairpipe.io.strands.tfx import read_tfx

        return read_tfx
    if suffix == ".abc":
        from hairpipe.io.strands.alembic_curves import read_alembic

        return read_alembic
    if suffix == ".hair":
        from hairpipe.io.strands.yuksel import read_hair

        return read_hair
    if suffix in (".data", ".bin"):
        from hairpipe.io.strands.records import read_records

        return read_records
    from hairpipe.io.strands.polylines import read_obj_strands, read_ply_strands

    return read_ply_strands if suffix == ".ply" else read_obj_strands
