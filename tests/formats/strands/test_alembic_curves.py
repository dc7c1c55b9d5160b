"""Alembic curves with the attributes of Unreal's specification, written by the library of Alembic."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.alembic import read_alembic

Abc = pytest.importorskip("alembic3d").Abc
G = pytest.importorskip("alembic3d").AbcGeom
imath = pytest.importorskip("imath")
UNIFORM, VERTEX = G.GeometryScope.kUniformScope, G.GeometryScope.kVertexScope
POINTS = np.arange(18, dtype=float).reshape(6, 3)


def filled(kind, rows):
    out = kind(len(rows))
    for i, row in enumerate(rows):
        out[i] = row
    return out


def parameter(parent, kind: str, name: str, values, scope) -> None:
    made = getattr(G, f"O{kind}GeomParam")(parent, name, False, scope, 1)
    made.set(getattr(G, f"O{kind}GeomParamSample")(values, scope))


def add_curves(parent, name: str, counts, points=POINTS, wrap=None):
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
    rest = filled(imath.V3fArray, [imath.V3f(*map(float, p)) for p in POINTS[::-1]])
    parameter(parameters, "V3f", "rest", rest, VERTEX)
    parameter(parameters, "Float", "tint", filled(imath.FloatArray, [0.5] * 6), VERTEX)
    parameter(parameters, "Float", "clump", filled(imath.FloatArray, [1.0, 2.0]), UNIFORM)


def test_attributes_of_unreal_are_read_and_others_named(tmp_path):
    path = tmp_path / "a.abc"
    write(path, groom)
    with pytest.warns(UserWarning, match="parameters that are not read: tint$"):
        found = read_alembic(path, 0.01, "z")
    assert {name: values.tolist() for name, values in found.maps.items()} == {"clump": [1.0, 2.0]}
    x, y, z = 0.01 * (POINTS + np.array([1, 2, 3])).T
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
