"""Headers of OpenVDB files, sound and damaged: a message, never a traceback, never a large allocation."""

import struct
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hairpipe.errors import BadInput
from hairpipe.formats.vdb import box, inspect


def text(value: str) -> bytes:
    return struct.pack("<I", len(value.encode())) + value.encode()


def entry(name: str, kind: str, data: bytes) -> bytes:
    return text(name) + text(kind) + struct.pack("<I", len(data)) + data


def metadata(*entries: bytes) -> bytes:
    return struct.pack("<I", len(entries)) + b"".join(entries)


def header(version: int = 224, offsets: bool = True) -> bytes:
    start = struct.pack("<qIII?", 0x56444220, version, 12, 0, offsets) + b"0" * 36
    return start + metadata(entry("creator", "string", b"somebody"))


def grid(at: int, name: str, kind: str, transform: bytes, *entries: bytes, voxels: bytes = b"v" * 50) -> bytes:
    """A grid that begins at a byte of the file."""
    descriptor = text(name) + text(kind) + text("")
    start = at + len(descriptor) + 24
    body = struct.pack("<I", 0) + metadata(*entries) + transform
    return descriptor + struct.pack("<3q", start, start + len(body), start + len(body) + len(voxels)) + body + voxels


def file_of(*grids: tuple) -> bytes:
    data = header() + struct.pack("<I", len(grids))
    for one in grids:
        data += grid(len(data), *one)
    return data


UNIFORM = text("UniformScaleMap") + struct.pack("<15d", *[0.5] * 15)
FRUSTUM = text("NonlinearFrustumMap") + b"?" * 80
BOX = {"min": (-4, 0, 2), "max": (4, 8, 10)}
SOUND = file_of(
    ("surface", "Tree_float_5_4_3_HalfFloat", UNIFORM, entry("class", "string", b"level set")),
    ("density\x1e1", "Tree_float_5_4_3", UNIFORM, entry("class", "string", b"unknown")),
    ("vel", "Tree_vec3s_5_4_3", UNIFORM, entry("odd", "matrix of mine", b"123")),
    ("warped", "Tree_bool_5_4_3", FRUSTUM, entry("gain", "double", struct.pack("<d", 2.5))),
)


def write(folder: Path, data: bytes) -> Path:
    path = folder / "file.vdb"
    path.write_bytes(data)
    return path


def test_grids_are_listed_in_order(tmp_path):
    grids = [(grid.name, grid.grid_class) for grid in inspect(write(tmp_path, SOUND))]
    assert grids == [("surface", "level set"), ("density", ""), ("vel", ""), ("warped", "")]


def test_a_level_set_says_how_large_it_is(tmp_path):
    corners = [entry(f"file_bbox_{end}", "vec3i", struct.pack("<3i", *at)) for end, at in BOX.items()]
    facts = [entry("class", "string", b"level set"), *corners, entry("voxel", "float", struct.pack("<f", 0.25))]
    path = write(tmp_path, file_of(("surface", "Tree_float_5_4_3", UNIFORM, *facts)))
    assert box(path) == ((-1.0, 0.0, 0.5), (1.0, 2.0, 2.5))


def test_grids_without_a_size_are_refused(tmp_path):
    with pytest.raises(BadInput, match=r"no level set 'surface' of known size.*export_vdb"):
        box(write(tmp_path, SOUND))


@pytest.mark.parametrize(
    ("data", "reported"),
    [
        (b"PNG\r\n" * 9, "not an OpenVDB file"),
        (header(213), r"the file has version 213 \(version 222 or later\)"),
        (header(offsets=False), "written as a stream"),
        (header()[:90], "the file ends"),
        (header() + struct.pack("<I", 2**32 - 1), "4294967295 entries are announced"),
        (header()[:57] + struct.pack("<I", 2**31), "2147483648 entries are announced"),
        (header() + struct.pack("<II", 1, 2**32 - 1) + b" " * 99, "the file ends where 4294967295 bytes"),
        (SOUND[:-80], "the next grid should be at byte"),
    ],
)
def test_damaged_files_are_refused(tmp_path, data, reported):
    with pytest.raises(BadInput, match=reported) as refusal:
        inspect(write(tmp_path, data))
    assert "file.vdb, byte" in str(refusal.value)


def test_offsets_that_lead_back_are_refused(tmp_path):
    at = SOUND.index(b"Tree_float_5_4_3_HalfFloat") + 26 + 4
    for place in (0, -1, 2**62):
        data = SOUND[:at] + struct.pack("<q", place) + SOUND[at + 8 :]
        with pytest.raises(BadInput, match="the next grid should be"):
            inspect(write(tmp_path, data))


def test_no_file_and_a_folder_are_refused(tmp_path):
    for path in (tmp_path / "missing.vdb", tmp_path):
        with pytest.raises(BadInput):
            inspect(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300, deadline=None)
@given(st.data())
def test_damage_gives_a_message_or_grids(tmp_path, data):
    damaged = bytearray(SOUND)
    for _ in range(data.draw(st.integers(1, 6))):
        damaged[data.draw(st.integers(0, len(SOUND) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.one_of(st.none(), st.integers(0, len(SOUND))))
    try:
        inspect(write(tmp_path, bytes(damaged[:cut])))
    except BadInput as refusal:
        assert "file.vdb" in str(refusal)
