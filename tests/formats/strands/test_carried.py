"""The table of formats in the pages: a groom with everything is written in each format, and read back within 1 um."""

import struct
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from hairpipe.engine import Frames, Time, Workspace
from hairpipe.formats.registry import read_strands
from hairpipe.nodes.export_alembic import export_alembic
from hairpipe.nodes.export_groom import export_groom
from hairpipe.nodes.export_usd import export_usd
from hairpipe.values import Groom, Strands
from hairpipe.values.groom import Curves
from hairpipe.values.strand_arrays import take
from tests.formats.complete_groom import complete_groom

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "groom_files.md"
CARRIED = {
    **{"ids": "ids", "widths": "widths", "root_uv": "root UV"},
    **{"groups": "groups", "guides": "guides", "colours": "colours", "maps": "maps"},
}
STRANDS, POINTS = 8, 5
OFFSETS = (POINTS * np.arange(STRANDS + 1)).astype(np.int32)


@pytest.fixture(scope="module")
def groom() -> Groom:
    return complete_groom(STRANDS, POINTS)


def hair(groom: Groom) -> bytes:
    head = b"HAIR" + struct.pack("<4I5f", STRANDS, STRANDS * POINTS, 2 + 4 + 16, POINTS - 1, 0, 0, 0, 0, 0) + bytes(88)
    return head + b"".join(a.astype("<f4").tobytes() for a in (groom.points, groom.widths, groom.colours))


def records(width: int) -> Callable[[Groom], bytes]:
    def write(groom: Groom) -> bytes:
        rows = np.hstack([groom.points, np.zeros((len(groom.points), width - 3))]).astype("<f4")
        parts = [struct.pack("<i", POINTS) + rows[a : a + POINTS].tobytes() for a in OFFSETS[:-1]]
        return struct.pack("<i", STRANDS) + b"".join(parts)

    return write


def ply(groom: Groom) -> bytes:
    names = ("x", "y", "z", "thickness", "red", "green", "blue")
    head = f"ply\nformat ascii 1.0\nelement vertex {len(groom.points)}\n"
    head += "".join(f"property float {name}\n" for name in names) + f"element strand {STRANDS}\nproperty int nsegs\n"
    rows = np.column_stack([groom.points, groom.widths, groom.colours])
    lines = [" ".join(f"{x:.9g}" for x in row) for row in rows] + [str(POINTS - 1)] * STRANDS
    return (head + "end_header\n" + "\n".join(lines)).encode()


def obj(groom: Groom) -> bytes:
    lines = ["v " + " ".join(f"{x:.9g}" for x in row) for row in groom.points]
    for s, start in enumerate(OFFSETS[:-1]):
        lines += [f"g {groom.group_names[groom.groups[s]]}", "l " + " ".join(str(start + 1 + i) for i in range(POINTS))]
    return "\n".join(lines).encode()


def tfx(groom: Groom) -> bytes:
    rows = np.hstack([groom.points, np.ones((len(groom.points), 1))]).astype("<f4")
    return struct.pack("<f3I", 4.0, STRANDS, POINTS, 160).ljust(160, b"\0") + rows.tobytes()


PLAIN = {"a.hair": hair, "a.data": records(3), "a.bin": records(7), "a.ply": ply, "a.obj": obj, "a.tfx": tfx}


def row_of(name: str, direction: str, found: Curves) -> str:
    """Write the row of a format: what strands have beyond their points."""
    given = {what for what in CARRIED if (value := getattr(found, what)) is not None and len(value)}
    if found.ids.tolist()[:2] == [0, 1]:  # mere places in the file
        given.discard("ids")
    return f"| {name} | {direction} | " + " | ".join("yes" if what in given else "" for what in CARRIED) + " |"


def has_maps(groom: Groom, found: Curves) -> bool:
    """Tell whether the hair of a file, without its guides, has the maps of the groom."""
    pairs = ((found.maps[name][~found.guides], values) for name, values in groom.maps.items())
    return found.maps.keys() == groom.maps.keys() and all(np.allclose(a, b, atol=1e-6) for a, b in pairs)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.skipif(find_spec("alembic3d") is None, reason="needs alembic3d")
def test_table_of_formats_is_what_comes_back(tmp_path, groom):
    rows = []
    for name, write in PLAIN.items():
        path = tmp_path / name
        path.write_bytes(write(groom))
        found = read_strands(path, 1.0, "y", None)
        assert np.abs(found.points - groom.points).max() < 1e-6
        assert found.widths is None or np.allclose(found.widths, groom.widths, rtol=1e-6)
        rows.append(row_of(f"`{name[1:]}`", "in", found))
    still = np.zeros((STRANDS * POINTS, 3), np.float32)
    frames = Frames((1, 2), lambda f: Strands(groom.points, still, OFFSETS, 1e-4))
    time = Time(1, 24.0)
    keys = take(groom, np.array([0, 5]))
    for target in ("unreal", "houdini", "blender"):
        folder = Workspace(tmp_path / target)
        folder.mkdir()
        path = export_groom(groom, frames, keys, None, None, time, folder, target=target).path
        found = read_strands(path, 1.0, "y", None, guides=True)
        points = found.points.reshape(-1, POINTS, 3)[~found.guides].reshape(-1, 3)
        assert np.abs(points - groom.points).max() < 1e-6 and has_maps(groom, found)
        rows.append(row_of(f'USD of `export_groom`, `target = "{target}"`', "in, out", found))
    for target in ("unreal", "houdini", "blender"):
        path = export_alembic(groom, frames, keys, None, time, Workspace(tmp_path / target), target=target).path
        found = read_strands(path, 0.01 if target == "unreal" else 1.0, "y", None, guides=True)
        points = found.points[:, [0, 2, 1]] if target == "unreal" else found.points  # its axes are left-handed
        assert np.abs(points[: len(groom.points)] - groom.points).max() < 1e-6 and has_maps(groom, found)
        rows.append(row_of(f'Alembic of `export_alembic`, `target = "{target}"`', "in, out", found))
    path = export_usd(frames, None, groom, None, keys, None, None, time, (), Workspace(tmp_path)).path
    found = read_strands(path, 1.0, "y", None)
    assert np.abs(found.points - groom.points).max() < 1e-6
    rows.append(row_of("USD of `export_usd`", "in, out", found))
    head = f"| format | direction | {' | '.join(CARRIED.values())} |\n|{' --- |' * (2 + len(CARRIED))}\n"
    table = head + "\n".join(rows)
    assert table in PAGE.read_text(encoding="utf-8"), f"the table of {PAGE.name} is to be\n\n{table}\n"
