"""Curves of Alembic with the attributes of Unreal's specification, read and written, and opened in Blender."""

import json
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from hairpipe.errors import BadInput
from hairpipe.formats.alembic import TARGETS, read_alembic, size_of, write_alembic
from hairpipe.formats.groom_shot import GroomShot
from hairpipe.formats.usd.curves import read_curves
from hairpipe.formats.usd.shot import write_groom
from hairpipe.values import Strands
from tests.formats.complete_groom import complete_groom

Abc = pytest.importorskip("alembic3d").Abc
G = pytest.importorskip("alembic3d").AbcGeom
imath = pytest.importorskip("imath")
UNIFORM, VERTEX = G.GeometryScope.kUniformScope, G.GeometryScope.kVertexScope
PLACES = np.arange(18, dtype=float).reshape(6, 3)


def filled(kind, rows):
    out = kind(len(rows))
    for i, row in enumerate(rows):
        out[i] = row
    return out


def parameter(parent, kind: str, name: str, values, scope) -> None:
    made = getattr(G, f"O{kind}GeomParam")(parent, name, False, scope, 1)
    made.set(getattr(G, f"O{kind}GeomParamSample")(values, scope))


def add_curves(parent, name: str, counts, points=PLACES, wrap=None):
    schema = G.OCurves(parent, name).getSchema()
    vertices = filled(imath.V3fArray, [imath.V3f(*map(float, p)) for p in points])
    sample = G.OCurvesSchemaSample(vertices, filled(imath.IntArray, counts), G.CurveType.kLinear)
    if wrap is not None:
        sample.setWrap(wrap)
    schema.set(sample)
    return schema


def write(path, fill) -> None:
    archive = Abc.OArchive(str(path))
    fill(archive.getTop())
    del archive


def groom(top) -> None:
    moved = G.OXform(top, "groom")
    sample = G.XformSample()
    sample.setTranslation(imath.V3d(1, 2, 3))
    moved.getSchema().set(sample)
    parameters = add_curves(moved, "hair", [4, 2]).getArbGeomParams()
    parameter(parameters, "Int32", "groom_id", filled(imath.IntArray, [70, 80]), UNIFORM)
    parameter(parameters, "Int16", "groom_guide", filled(imath.ShortArray, [0, 1]), UNIFORM)
    uv = filled(imath.V2fArray, [imath.V2f(0.1, 0.2), imath.V2f(0.3, 0.4)])
    parameter(parameters, "V2f", "groom_root_uv", uv, UNIFORM)
    colours = filled(imath.C3fArray, [imath.Color3f(k / 8, 0, 1) for k in range(6)])
    parameter(parameters, "C3f", "groom_color", colours, VERTEX)
    parameter(parameters, "Float", "groom_width", filled(imath.FloatArray, [0.5, 0.25]), UNIFORM)
    parameter(parameters, "String", "groom_group_name", filled(imath.StringArray, ["tail", "fringe"]), UNIFORM)
    rest = filled(imath.V3fArray, [imath.V3f(*map(float, p)) for p in PLACES[::-1]])
    parameter(parameters, "V3f", "rest", rest, VERTEX)
    parameter(parameters, "Float", "tint", filled(imath.FloatArray, [0.5] * 6), VERTEX)
    parameter(parameters, "Float", "clump", filled(imath.FloatArray, [1.0, 2.0]), UNIFORM)


def test_attributes_of_unreal_are_read_and_others_named(tmp_path):
    path = tmp_path / "a.abc"
    write(path, groom)
    with pytest.warns(UserWarning, match="parameters that are not read: tint$"):
        found = read_alembic(path, 0.01, "z")
    assert {name: values.tolist() for name, values in found.maps.items()} == {"clump": [1.0, 2.0]}
    x, y, z = 0.01 * (PLACES + np.array([1, 2, 3])).T
    assert np.allclose(found.points, np.stack([x, z, -y], axis=1), atol=1e-9)
    assert np.allclose(found.rest, found.points[::-1], atol=1e-9)
    assert found.offsets.tolist() == [0, 4, 6] and found.ids.tolist() == [70, 80]
    assert found.guides.tolist() == [False, True]
    assert np.allclose(found.root_uv, [[0.1, 0.2], [0.3, 0.4]])
    assert np.allclose(found.colours, [[k / 8, 0, 1] for k in range(6)])
    assert np.allclose(found.widths, 0.01 * np.array([0.5, 0.5, 0.5, 0.5, 0.25, 0.25]))
    assert found.groups.tolist() == [1, 0] and found.group_names == ("fringe", "tail")


def test_maps_of_several_objects_are_joined(tmp_path):
    def hair(top):
        for name, values in (("beard", None), ("tail", [3.0, 4.0])):
            parameters = add_curves(top, name, [3, 3]).getArbGeomParams()
            if values:
                parameter(parameters, "Float", "frizz", filled(imath.FloatArray, values), UNIFORM)

    path = tmp_path / "a.abc"
    write(path, hair)
    assert read_alembic(path).maps["frizz"].tolist() == [0.0, 0.0, 3.0, 4.0]


def test_objects_without_groups_are_groups(tmp_path):
    path = tmp_path / "a.abc"
    write(path, lambda top: [add_curves(top, name, [3, 3]) for name in ("tail", "beard")])
    found = read_alembic(path)
    assert found.groups.tolist() == [1, 1, 0, 0] and found.group_names == ("beard", "tail") and found.widths is None


def test_bad_files_are_reported_in_one_line(tmp_path):
    path = tmp_path / "bad.abc"
    write(path, lambda top: add_curves(top, "ring", [6], wrap=G.CurvePeriodicity.kPeriodic))
    with pytest.raises(BadInput, match=r"bad\.abc /ring: the curves are closed"):
        read_alembic(path)
    write(path, lambda top: add_curves(top, "hair", [4, 3]))
    with pytest.raises(BadInput, match=r"numbers of points sum to 7 \(6\)"):
        read_alembic(path)
    write(path, lambda top: G.OXform(top, "empty"))
    with pytest.raises(BadInput, match="there are no curves"):
        read_alembic(path)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(BadInput, match="not a readable Alembic file"):
        read_alembic(path)


library = pytest.importorskip("alembic3d")
STRANDS, POINTS, FPS = 4, 5, 24.0
SPEED = np.array([0.0, 0.24, -0.48], np.float32)


def moving(frames: range) -> GroomShot:
    """A groom at a constant velocity, whose last strand is a guide of the others."""
    groom = replace(complete_groom(STRANDS, POINTS), guides=np.arange(STRANDS) == STRANDS - 1)
    still = np.tile(SPEED, (len(groom.points), 1))
    hair = {k: Strands(groom.points + still * (k - frames[0]) / FPS, still, groom.offsets, 1e-4) for k in frames}
    closest = (np.full((STRANDS, 3), groom.ids[-1]), np.tile((1.0, 0.0, 0.0), (STRANDS, 1)))
    return GroomShot(groom, hair or None, closest, None, FPS)


def curves_of(path, name: str):
    top = library.Abc.IArchive(str(path)).getTop().getChild("groom")
    return top, library.AbcGeom.ICurves(top.getChild(name), name).getSchema()


@pytest.mark.parametrize("frames", [range(1001, 1004), range(1001, 1010, 4)])
@pytest.mark.parametrize("target", list(TARGETS))
def test_samples_are_at_the_times_of_frames(tmp_path, target, frames):
    shot, path = moving(frames), tmp_path / "a.abc"
    write_alembic(path, shot, target)
    _, schema = curves_of(path, "hair")
    sampling = schema.getTimeSampling()
    assert schema.getNumSamples() == len(frames)
    rows = shot.rows(shot.pieces(TARGETS[target].apart)["hair"])
    for sample, frame in enumerate(frames):
        time = sampling.getSampleTime(sample)
        assert time == pytest.approx(frame / FPS, abs=1e-9)
        value = schema.getValue(library.Abc.ISampleSelector(float(time)))
        assert np.allclose(
            np.array(value.getPositions()), TARGETS[target].placed(shot.hair[frame].points[rows]), atol=1e-5
        )
        assert np.allclose(np.array(value.getVelocities())[0], TARGETS[target].placed(SPEED), rtol=1e-6)


def test_frames_with_gaps_keep_their_times(tmp_path):
    shot, path = moving(range(1001, 1011)), tmp_path / "a.abc"
    write_alembic(path, replace(shot, hair={k: shot.hair[k] for k in (1001, 1002, 1010)}), "houdini")
    sampling = curves_of(path, "hair")[1].getTimeSampling()
    assert [round(sampling.getSampleTime(k) * FPS, 6) for k in range(3)] == [1001, 1002, 1010]


def test_unreal_finds_its_attributes_with_types_and_scopes(tmp_path):
    shot, path = moving(range(0)), tmp_path / "a.abc"
    write_alembic(path, shot, "unreal")
    top, schema = curves_of(path, "hair")
    properties = library.AbcGeom.IXform(top.getParent(), "groom").getSchema().getUserProperties()
    versions = [
        library.Abc.IInt16Property(properties, f"groom_version_{part}").getValue() for part in ("major", "minor")
    ]
    assert versions == [1, 5]
    parameters = schema.getArbGeomParams()
    headers = [parameters.getPropertyHeader(k) for k in range(parameters.getNumProperties())]
    types = {h.getName(): (str(h.getDataType()), h.getMetaData().get("geoScope")) for h in headers}
    assert types == {
        "groom_id": ("int32_t", "uni"),
        "groom_guide": ("int32_t", "uni"),
        "groom_group_id": ("int32_t", "uni"),
        "groom_group_name": ("string", "uni"),
        "groom_root_uv": ("float32_t[2]", "uni"),
        "clump": ("float32_t", "uni"),
        "groom_frizz": ("float32_t", "uni"),
        "groom_closest_guides": ("int32_t[3]", "uni"),
        "groom_guide_weights": ("float32_t[3]", "uni"),
        "groom_color": ("float32_t[3]", "vtx"),
    }
    root = np.array(schema.getValue().getPositions())[0]
    x, y, z = shot.groom.points[0]
    assert np.allclose(root, [100 * x, 100 * z, 100 * y], atol=1e-4)  # left-handed, Z up
    assert np.allclose(
        np.array(schema.getWidthsParam().getExpandedValue().getVals()), 100 * shot.groom.widths, rtol=1e-6
    )


def named(name: str) -> GroomShot:
    shot = moving(range(0))
    return replace(shot, groom=replace(shot.groom, maps={name: np.arange(4.0), **shot.groom.maps}))


@pytest.mark.filterwarnings("ignore:.*not read")
def test_a_map_keeps_its_name_or_is_named(tmp_path):
    path = tmp_path / "a.abc"
    with pytest.warns(UserWarning, match="the map 'of mine' of the groom is written as of_mine"):
        write_alembic(path, named("of mine"), "houdini")
    assert read_alembic(path).maps["of_mine"].tolist() == [0.0, 1.0, 2.0, 3.0]
    for taken in ("width", "groom_id", "rest", "groom_guide_weights", "groom.frizz"):
        with pytest.raises(BadInput, match=f"the map '{taken}' of the groom has the name of another attribute"):
            write_alembic(path, named(taken), "houdini")


@pytest.mark.filterwarnings("ignore:.*not read")
@pytest.mark.parametrize("suffix", [".abc", ".usdc"])
def test_widths_change_over_time(tmp_path, suffix):
    """Until the third frame they are those of the first; then hair and guide are twice as wide."""
    shot, path = moving(range(1001, 1005)), tmp_path / f"a{suffix}"
    wide = {k: (1.0 + (k > 1002)) * shot.groom.widths.astype(np.float32) for k in shot.hair}
    shot = replace(shot, hair={k: replace(hair, widths=wide[k]) for k, hair in shot.hair.items()})
    if suffix == ".abc":
        write_alembic(path, shot, "houdini")
        assert path.stat().st_size < size_of(shot)
        parameters = [curves_of(path, name)[1].getWidthsParam() for name in ("hair", "guides")]
        values = [
            [param.getExpandedValue(library.Abc.ISampleSelector(k / FPS)).getVals() for param in parameters]
            for k in shot.hair
        ]
    else:
        write_groom(path, shot, "houdini")
        stage = Usd.Stage.Open(str(path))
        attributes = [
            UsdGeom.BasisCurves(stage.GetPrimAtPath(f"/groom/{name}")).GetWidthsAttr() for name in ("hair", "guides")
        ]
        assert [a.GetTimeSamples() for a in attributes] == 2 * [[1002.0, 1003.0, 1004.0]]
        values = [[a.Get(k) for a in attributes] for k in shot.hair]
        assert read_curves(path, time=1004, guides=True).widths == pytest.approx(wide[1004], rel=1e-6)
    for k, pieces in zip(shot.hair, values, strict=True):
        assert np.concatenate([np.array(piece) for piece in pieces]) == pytest.approx(wide[k], rel=1e-6)


@pytest.mark.filterwarnings("ignore:.*not read", "ignore:.*not used", "ignore:.*is read")
@pytest.mark.parametrize("suffix", [".abc", ".usdc"])
@pytest.mark.parametrize("target", list(TARGETS))
def test_strands_that_represent_many_hairs_are_drawn_wide(tmp_path, target, suffix):
    """Three strands represent 30 hairs, the fourth is a guide."""
    shot, path = replace(moving(range(1001, 1003)), hairs=30), tmp_path / f"a{suffix}"
    (write_alembic if suffix == ".abc" else write_groom)(path, shot, target)
    if suffix == ".abc":
        widths = np.array(curves_of(path, "hair")[1].getWidthsParam().getExpandedValue().getVals())
        found = read_alembic(path, TARGETS[target].metres)
    else:
        stage = Usd.Stage.Open(str(path))
        widths = np.array(UsdGeom.BasisCurves(stage.GetPrimAtPath("/groom/hair")).GetWidthsAttr().Get())
        found = read_curves(path, time=1001, guides=True)
    at_roots = TARGETS[target].metres * widths[: 3 * POINTS : POINTS]
    assert at_roots == pytest.approx(10.0 * shot.groom.widths[: 3 * POINTS : POINTS], rel=1e-6)
    assert (widths[POINTS - 1 :: POINTS] == 0.0).all()
    assert found.widths == pytest.approx(shot.groom.widths, rel=1e-6)


@pytest.mark.filterwarnings("ignore:.*not read")
def test_guides_and_rest_shape_come_back(tmp_path):
    shot, path = moving(range(0)), tmp_path / "a.abc"
    write_alembic(path, shot, "houdini")
    found = read_alembic(path)
    assert found.guides.tolist() == shot.groom.guides.tolist() and found.ids.tolist() == shot.groom.ids.tolist()
    assert np.abs(found.points - shot.groom.points).max() < 1e-6
    assert np.abs(found.rest - shot.groom.points).max() < 1e-6
    rest = library.AbcGeom.IV3fGeomParam(curves_of(path, "guides")[1].getArbGeomParams(), "rest")
    assert np.allclose(np.array(rest.getExpandedValue().getVals()), shot.groom.points[-POINTS:], atol=1e-6)


def test_files_are_the_same_bytes_each_time_and_no_larger_than_announced(tmp_path):
    shot = moving(range(1001, 1004))
    for name in ("a.abc", "b.abc"):
        write_alembic(tmp_path / name, shot, "unreal")
    assert (tmp_path / "a.abc").read_bytes() == (tmp_path / "b.abc").read_bytes()
    assert (tmp_path / "a.abc").stat().st_size < size_of(shot)


def test_broken_hair_and_missing_folders_are_reported(tmp_path):
    shot = moving(range(1001, 1002))
    with pytest.raises(BadInput, match=r"the Alembic file was not written: .*a folder with space"):
        write_alembic(tmp_path, shot, "unreal")
    broken = replace(shot.hair[1001], points=np.full_like(shot.groom.points, np.nan))
    with pytest.raises(BadInput, match="hair at frame 1001: points are not all finite"):
        write_alembic(tmp_path / "a.abc", replace(shot, hair={1001: broken}), "unreal")


def test_full_disk_is_reported_before_the_file_is_begun(tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=1000))
    with pytest.raises(OSError, match="No space left on device"):
        write_alembic(tmp_path / "a.abc", moving(range(1001, 1002)), "unreal")
    assert not list(tmp_path.iterdir())


SHOWN = """
import json, sys, bpy, numpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.alembic_import(filepath=sys.argv[1], as_background_job=False)
bpy.context.scene.render.fps = 24
bpy.context.scene.frame_set(1003)
shown = {}
for item in bpy.context.evaluated_depsgraph_get().objects:
    if item.type == "CURVES":
        points = numpy.empty(3 * len(item.data.points), numpy.float32)
        item.data.attributes["position"].data.foreach_get("vector", points)
        matrix = numpy.array(item.matrix_world)
        placed = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        shown[item.name] = [len(item.data.curves), placed.tolist(), item.data.attributes["radius"].data[0].value]
print("shown", json.dumps(shown))
"""


def test_blender_shows_hair_and_guides_where_they_are(tmp_path, blender):
    shot, path = moving(range(1001, 1004)), tmp_path / "a.abc"
    write_alembic(path, shot, "blender")
    done = subprocess.run([sys.executable, "-c", SHOWN, str(path)], capture_output=True, text=True, timeout=120)
    line = next(line for line in done.stdout.splitlines() if line.startswith("shown"))
    shown = json.loads(line.removeprefix("shown"))
    points = shot.hair[1003].points
    x, y, z = points[: (STRANDS - 1) * POINTS].T
    assert set(shown) == {"hair", "guides"} and [shown[name][0] for name in ("hair", "guides")] == [STRANDS - 1, 1]
    assert np.allclose(shown["hair"][1], np.stack([x, -z, y], axis=1), atol=1e-6)
    assert len(shown["guides"][1]) == POINTS
    assert 2 * shown["hair"][2] == pytest.approx(shot.groom.widths[0], rel=1e-5)
