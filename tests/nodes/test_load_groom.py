"""Hair made elsewhere, on the body it was made for."""

import struct
from pathlib import Path

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.importing import EQUAL
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_groom import load_groom
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Body, Mesh, Skeleton

USD = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
)
def BasisCurves "hair"
{
    uniform token type = "linear"
    int[] curveVertexCounts = [3, 2]
    point3f[] points = [(10, 0, 10), (10, 10, 10), (10, 30, 10), (20, 0, 50), (20, 8, 50)]
}
"""


@pytest.fixture
def floor() -> Body:
    """A square metre of floor."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1.0]])
    mesh = Mesh(points, np.array([[0, 2, 1], [0, 3, 2]], np.int32))
    skeleton = Skeleton(("root",), np.array([-1], np.int32), np.eye(4)[None], np.array([[0.0, 1.0, 0.0]]))
    return Body(mesh, skeleton, np.zeros((4, 1), np.int32), np.ones((4, 1)))


def test_usd_curves_are_bound_in_metres(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    file.write_text(USD)
    groom = load_groom(floor, file=file, segments=3)
    strands = groom.points.reshape(2, 4, 3)
    assert np.allclose(strands[0, :, 1], [0.0, 0.1, 0.2, 0.3], atol=1e-7)
    assert np.allclose(strands[1, :, 1], np.linspace(0, 0.08, 4), atol=1e-7)
    assert np.allclose(groom.root_frames[:, :, 2], (0, 1, 0))
    assert np.allclose(groom.root_frames[:, :, 3], [[0.1, 0, 0.1], [0.2, 0, 0.5]])


def test_sintels_hair_grows_on_sintel(shared: Path) -> None:
    scalp = load_body(file=shared / "sintel" / "sintel.obj")
    file = shared / "sintel" / "SintelHairOriginal-sintel_hair.16points.tfx"
    groom = load_groom(scalp, file=file)
    assert len(groom.ids) == 11_400 and np.array_equal(np.diff(groom.offsets), np.full(11_400, 16))
    lengths = np.linalg.norm(np.diff(groom.points.reshape(-1, 16, 3), axis=1), axis=2)
    assert (np.ptp(lengths, axis=1) <= EQUAL).all()
    assert np.allclose(np.quantile(lengths.sum(axis=1), (0, 0.5, 1)), (0.025, 0.102, 0.248), atol=2e-3)
    off = np.linalg.norm(groom.points[groom.offsets[:-1]] - groom.root_frames[:, :, 3], axis=1)
    assert np.median(off) < 0.64e-3 and 6.0e-3 < off.max() < 6.3e-3
    fewer = load_groom(scalp, file=file, strands=500, segments=10)
    assert len(fewer.points) == 500 * 11 and np.array_equal(fewer.root_frames, groom.root_frames[fewer.ids])


def test_short_strands_are_simulated_once_they_are_loaded(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    points = "(10, 0, 10), (10, 10, 10), (10, 30, 10), (20, 0, 50), (20, 0.02, 50), (30, 0, 50), (30, 0.5, 50)"
    file.write_text(USD.replace("[3, 2]", "[3, 2, 2]").split("points =")[0] + f"points = [{points}]\n}}\n")
    with pytest.warns(UserWarning) as reported:
        groom = load_groom(floor, file=file, segments=12)
    assert [str(warning.message).partition(",")[0] for warning in reported] == [
        "1 strands are left out",
        "1 strands are cut into fewer segments",
    ]
    assert np.diff(groom.offsets).tolist() == [13, 6] and groom.ids.tolist() == [0, 2]
    hair, scene = build_hair(groom, Material(), "network"), Scene()
    still = (floor.mesh, floor.mesh)
    state = advance_frame(hair, start(hair, floor.mesh, scene), still, (), 1 / 24, scene)
    moved = strands_of(hair, state).points
    assert np.isfinite(moved).all() and np.allclose(moved[groom.offsets[:-1]], groom.points[groom.offsets[:-1]])


def test_segments_by_their_length(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    file.write_text(USD)
    assert np.diff(load_groom(floor, file=file, segment_length=0.05).offsets).tolist() == [7, 3]


def tfx_3(strands: list[list[tuple[float, float, float]]], held: int) -> bytes:
    """A TressFX file of version 3."""
    header = struct.pack("<f4I", 3.0, len(strands), len(strands[0]), 0, held).ljust(144, b"\0")
    header = (header + struct.pack("<I", 296)).ljust(296, b"\0")
    return header + b"".join(struct.pack("<3f", *point) for strand in strands for point in strand)


def test_tressfx_of_both_ends_immovable_is_held_by_the_body(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "tail.tfx"
    loop = [(0.2, 0.0, 0.2), (0.2, 0.1, 0.2), (0.3, 0.1, 0.2), (0.3, 0.0, 0.2)]
    file.write_bytes(tfx_3([loop], held=1))
    groom = load_groom(floor, file=file, segments=8)
    assert groom.tip_triangles is not None and np.allclose(groom.tip_frames[0, :, 3], loop[-1])
    file.write_bytes(tfx_3([loop], held=0))
    assert load_groom(floor, file=file, segments=8).tip_triangles is None
    assert load_groom(floor, file=file, segments=8, tips="held").tip_triangles is not None


def test_faults_of_strands_name_the_file(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "far.tfx"
    file.write_bytes(tfx_3([[(0.2, 9.0, 0.2), (0.2, 9.1, 0.2)]], held=0))
    with pytest.raises(
        BadInput, match=r"far\.tfx: roots up to 9 m away .*: strands 0; all are displaced by one vector, \(0, 9, 0\) m"
    ):
        load_groom(floor, file=file)


def test_a_b_spline_from_blender_begins_at_its_first_control_vertex(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    file.write_text(
        USD.replace('"linear"', '"cubic"')
        .replace("{\n    uniform", '{\n    uniform token basis = "bspline"\n    uniform')
        .split("    int[]")[0]
        + "    int[] curveVertexCounts = [4]\n"
        + "    point3f[] points = [(10, 0, 10), (10, 10, 10), (10, 20, 10), (10, 30, 10)]\n"
        + '    float[] widths = [0.01]\n    int[] primvars:hairId = [77] (interpolation = "uniform")\n}\n'
    )
    groom = load_groom(floor, file=file)
    assert np.allclose(groom.points[0], (0.1, 0.0, 0.1), atol=1e-7), "and not 0.1 m above it"
    assert np.allclose(groom.points[-1], (0.1, 0.3, 0.1), atol=1e-7)
    assert groom.ids.tolist() == [77] and np.allclose(groom.widths, 1e-4)


def test_points_of_the_file_are_kept_on_request_and_not_simulated(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    file.write_text(USD)
    groom = load_groom(floor, file=file, points="file")
    assert np.allclose(
        groom.points, np.array([(10, 0, 10), (10, 10, 10), (10, 30, 10), (20, 0, 50), (20, 8, 50)]) / 100
    )
    with pytest.raises(BadInput, match=r"segments of strand 0 are 1e\+02 to 2e\+02 mm long \(equal segments"):
        build_hair(groom, Material(), "rod")
    with pytest.raises(BadInput, match=r'segments with points = "file"'):
        load_groom(floor, file=file, points="file", segments=3)


def test_equal_segments_come_back_unchanged(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    turns = np.linspace(0, 8, 60)
    helix = np.float32(np.stack([0.3 + 0.01 * np.cos(turns), 0.01 * turns, 0.3 + 0.01 * np.sin(turns)], axis=1))
    text = ", ".join(f"({x}, {y}, {z})" for x, y, z in 100.0 * helix.astype(float))
    file.write_text(
        USD.split("    int[]")[0] + f"    int[] curveVertexCounts = [60]\n    point3f[] points = [{text}]\n}}\n"
    )
    assert np.abs(load_groom(floor, file=file).points - helix).max() < 1e-7, "and not 9 um along the curve"


def test_guides_or_the_others_are_selected(floor: Body, tmp_path: Path) -> None:
    file = tmp_path / "hair.usda"
    file.write_text(USD.rstrip("}\n") + '\n    int[] primvars:groom_guide = [0, 1] (interpolation = "uniform")\n}\n')
    assert load_groom(floor, file=file, select="guides").ids.tolist() == [1]
    assert load_groom(floor, file=file, select="hair").ids.tolist() == [0]
    assert load_groom(floor, file=file).guides.tolist() == [False, True]
    file.write_text(USD)
    with pytest.raises(BadInput, match=r"hair\.usda: no curve is a guide"):
        load_groom(floor, file=file, select="guides")
