"""glTF files that Blender wrote, against the points that Blender shows; and files made by hand, against theory."""

import base64
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.skinning import skin
from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.formats.gltf import Document, list_files
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.nodes.load_motion import load_motion

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0]], np.float32)


class Writer:
    """A glTF file, made accessor by accessor."""

    def __init__(self) -> None:
        self.data = b""
        self.views: list[dict] = []
        self.accessors: list[dict] = []

    def add(self, values: np.ndarray, kind: str, **more: object) -> int:
        code = {"f": 5126, "u": {1: 5121, 2: 5123, 4: 5125}.get(values.itemsize), "i": 5122}[values.dtype.kind]
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.tobytes() + bytes(-values.nbytes % 4)
        accessor = {"bufferView": len(self.views) - 1, "componentType": code, "count": len(values), "type": kind}
        self.accessors.append(accessor | more)
        return len(self.accessors) - 1

    def json(self, **content: object) -> dict:
        text = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        buffers = [{"byteLength": len(self.data), "uri": text}]
        parts = {"bufferViews": self.views, "accessors": self.accessors, "buffers": buffers}
        return {"asset": {"version": "2.0"}, **parts, **content}


def turning(kind: str, keys: np.ndarray, values: np.ndarray, path: str = "rotation") -> dict:
    """A triangle whose node is animated by keys."""
    writer = Writer()
    mesh = {"primitives": [{"attributes": {"POSITION": writer.add(TRIANGLE, "VEC3")}}]}
    shape = {"rotation": "VEC4", "translation": "VEC3"}[path]
    sampler = {
        "input": writer.add(keys.astype(np.float32), "SCALAR"),
        "output": writer.add(values.astype(np.float32), shape),
        "interpolation": kind,
    }
    channel = {"sampler": 0, "target": {"node": 0, "path": path}}
    animations = [{"name": "turn", "samplers": [sampler], "channels": [channel]}]
    return writer.json(meshes=[mesh], nodes=[{"mesh": 0, "name": "leaf"}], animations=animations)


def write(path: Path, content: dict) -> Path:
    path.write_text(json.dumps(content))
    return path


def points_at(file: Path, frame: int, **settings) -> np.ndarray:
    return load_mesh_cache(Time(frame, 24.0), (), file=file, at=0, **settings).points


def test_two_keys_of_a_rotation_turn_along_an_arc(tmp_path):
    keys = np.array([0.0, 2.0])
    ends = Rotation.from_euler("z", [[0.0], [170.0]], degrees=True).as_quat()
    file = write(tmp_path / "turn.gltf", turning("LINEAR", keys, ends))
    for frame in (0, 7, 24, 48):
        mesh = load_mesh_cache(Time(frame, 24.0), (), file=file, at=0)
        angle = 170.0 * frame / 48
        np.testing.assert_allclose(
            mesh.points, Rotation.from_euler("z", angle, degrees=True).apply(TRIANGLE), atol=1e-6
        )
        rate = np.radians(85.0)
        np.testing.assert_allclose(mesh.velocities, np.cross([0, 0, rate], mesh.points), atol=6e-3)


def test_cubic_and_step_keys_follow_their_definition(tmp_path):
    keys = np.array([0.0, 1.0])
    cubic = np.array([[0, 0, 0], [0, 0, 0], [3, 0, 0], [-3, 0, 0], [1, 0, 0], [0, 0, 0]], float)
    file = write(tmp_path / "cubic.gltf", turning("CUBICSPLINE", keys, cubic, "translation"))
    u = 0.25
    moved = 3 * (u**3 - 2 * u**2 + u) + (3 * u**2 - 2 * u**3) - 3 * (u**3 - u**2)
    np.testing.assert_allclose(points_at(file, 6) - TRIANGLE, np.tile([moved, 0, 0], (3, 1)), atol=1e-6)
    step = np.array([[0, 0, 0], [1, 0, 0]], float)
    file = write(tmp_path / "step.gltf", turning("STEP", keys, step, "translation"))
    np.testing.assert_allclose(points_at(file, 23), TRIANGLE, atol=1e-6)


def test_sparse_and_normalised_numbers_are_read(tmp_path):
    writer = Writer()
    small = writer.add(np.array([0, 128, 255], np.uint8), "SCALAR", normalized=True)
    rows = writer.add(np.array([1], np.uint16), "SCALAR")
    values = writer.add(np.array([[7.0, 8.0, 9.0]], np.float32), "VEC3")
    views = [writer.accessors[k]["bufferView"] for k in (rows, values)]
    sparse = {
        "count": 1,
        "indices": {"bufferView": views[0], "componentType": 5123},
        "values": {"bufferView": views[1]},
    }
    writer.accessors.append({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse})
    document = Document(write(tmp_path / "a.gltf", writer.json()))
    np.testing.assert_allclose(document.numbers(small, 1), np.array([0, 128, 255]) / 255)
    np.testing.assert_array_equal(document.numbers(3, 3), [[0, 0, 0], [7, 8, 9], [0, 0, 0]])


def broken(change) -> dict:
    content = turning("LINEAR", np.array([0.0, 1.0]), np.array([[0, 0, 0], [1, 0, 0]], float), "translation")
    change(content)
    return content


def chain(content: dict, number: int) -> None:
    """Add nodes below each other, whose transforms cannot be multiplied."""
    content["nodes"] += [{"matrix": [1e12] * 16, "children": [n + 2]} for n in range(number)] + [{}]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.update(asset={"version": "1.0"}), r"a.gltf: the version of glTF is 1.0 \(2.0\)"),
        (lambda c: c.update(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression, which is"),
        (lambda c: c["accessors"][0].update(count=1000), "a.gltf, accessor 0: ends at byte 12,000 of a buffer of 68"),
        (
            lambda c: c["accessors"][1].update(bufferView=99),
            r"a.gltf, accessors\[1\].bufferView: the value is 99 \(one of the 3 ",
        ),
        (lambda c: c["nodes"][0].pop("mesh"), r"no mesh \(a node with a mesh"),
        (lambda c: (c.update(scenes=[{"nodes": [0]}]), c["nodes"][0].update(children=[0])), "not a tree"),
        (lambda c: c["buffers"][0].update(uri="none.bin"), r"a.gltf: the buffer 'none.bin': the file cannot be read"),
        (lambda c: c["nodes"][0].update(children=[1, 1]) or c["nodes"].append({}), r"nodes\[1\]: its nodes are not a"),
        (lambda c: c["nodes"][0].update(mesh="x"), r"nodes\[0\].mesh: the value is 'x' \(one of the 1 meshes, from 0"),
        (lambda c: c["nodes"][0].update(scale=[1, 1, 1e300]), r"nodes\[0\].scale: the value is .* \(3 numbers\)"),
        (lambda c: c["animations"][0]["samplers"][0].pop("input"), r"samplers\[0\]: the value is missing \(input"),
        (lambda c: c["animations"][0]["channels"][0].update(sampler=1), "node 0: there is no sampler 1"),
        (lambda c: c["animations"][0]["samplers"][0].update(input=2), "accessor 2: is a VEC3"),
        (lambda c: c["meshes"][0]["primitives"][0].update(targets=[{"POSITION": 2}]), "2 elements for 3 vertices"),
        (lambda c: c["nodes"][0].update(matrix=[1e12] * 16, children=[1]) or chain(c, 40), "transform is not finite"),
    ],
)
def test_bad_files_are_refused(tmp_path, change, message):
    with pytest.raises(BadInput, match=message):
        points_at(write(tmp_path / "a.gltf", broken(change)), 1)
    (tmp_path / "b.glb").write_bytes(b"glTF" + bytes(30))
    with pytest.raises(BadInput, match=r"b.glb: there is no chunk JSON"):
        points_at(tmp_path / "b.glb", 1)


def test_an_unknown_clip_is_refused_with_the_known_ones(tmp_path):
    file = write(tmp_path / "a.gltf", broken(lambda c: None))
    with pytest.raises(BadInput, match=r"no animation 'walk' \(one of turn\)"):
        points_at(file, 1, clip="walk")


def test_buffers_are_files_of_a_key(tmp_path):
    file = write(tmp_path / "a.gltf", broken(lambda c: c["buffers"][0].update(uri="b%20c.bin")))
    (tmp_path / "b c.bin").write_bytes(b"0")
    assert list_files(file) == {"a.gltf": file, "b c.bin": tmp_path / "b c.bin"}


def morphing(rest: list[float]) -> dict:
    """A strip that two joints bend, bound in another pose than the one of rest, with two morph targets over time."""
    writer = Writer()
    rng = np.random.default_rng(4)
    points = rng.normal(size=(6, 3)).astype(np.float32)
    targets = rng.normal(size=(2, 6, 3)).astype(np.float32)
    targets[0, 2:] = 0.0
    weights = np.zeros((6, 4), np.float32)
    weights[:, 0] = np.linspace(0.0, 1.0, 6)
    weights[:, 1] = 1.0 - weights[:, 0]
    bind = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
    bind[1, :3, :3] = Rotation.from_euler("x", 30.0, degrees=True).as_matrix()
    given = {
        "POSITION": writer.add(points, "VEC3"),
        "JOINTS_0": writer.add(np.tile(np.array([0, 1, 0, 0], np.uint8), (6, 1)), "VEC4"),
        "WEIGHTS_0": writer.add(weights, "VEC4"),
    }
    corners = writer.add(np.array([0, 1, 2, 2, 3, 4, 3, 5, 4], np.uint16), "SCALAR")
    times = writer.add(np.array([0.0, 1.0], np.float32), "SCALAR")
    turns = Rotation.from_euler("z", [[0.0], [80.0]], degrees=True).as_quat().astype(np.float32)
    samplers = [
        {"input": times, "output": writer.add(turns, "VEC4")},
        {"input": times, "output": writer.add(np.array([0.0, 1.0, 1.5, -0.5], np.float32), "SCALAR")},
    ]
    channels = [
        {"sampler": 0, "target": {"node": 2, "path": "rotation"}},
        {"sampler": 1, "target": {"node": 0, "path": "weights"}},
    ]
    primitive = {
        "attributes": given,
        "indices": corners,
        "targets": [{"POSITION": writer.add(target, "VEC3")} for target in targets],
    }
    inverse = writer.add(np.ascontiguousarray(bind.swapaxes(1, 2)).reshape(2, 16), "MAT4")
    return writer.json(
        meshes=[{"primitives": [primitive], "weights": rest, "extras": {"targetNames": ["smile", "puff"]}}],
        nodes=[{"mesh": 0, "skin": 0}, {"name": "upper", "children": [2]}, {"name": "lower", "translation": [0, 1, 0]}],
        skins=[{"joints": [1, 2], "inverseBindMatrices": inverse}],
        animations=[{"name": "talk", "samplers": samplers, "channels": channels}],
    )


@pytest.mark.parametrize("default", [[0.0, 0.0], [0.5, -0.25]])
def test_poses_carry_morph_targets_as_the_points_of_the_file(tmp_path, default):
    file = write(tmp_path / "a.gltf", morphing(default))
    rest = load_body(file=file)
    assert rest.shapes.names == ("smile", "puff") and rest.shapes.rest.tolist() == default
    for frame in (0, 9, 24):
        pose = load_motion(rest, Time(frame, 24.0), (), file=file, at=0)
        share = frame / 24
        np.testing.assert_allclose(pose.weights, [1.5 * share, 1.0 - 1.5 * share], atol=1e-6)
        mesh = load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=file, at=0)
        np.testing.assert_allclose(skin(rest, pose).points, mesh.points, atol=1e-6)
    still = skin(rest, replace(pose, transforms=rest.skeleton.rest, weights=None))
    np.testing.assert_allclose(still.points, rest.mesh.points, atol=1e-6)


@pytest.mark.parametrize("names", [["smile", "puff"], ["smile", "smile"], None, "null"])
def test_morph_targets_of_two_primitives_follow_their_weight(tmp_path, names):
    content = morphing([0.0, 0.0])
    mesh = content["meshes"][0]
    first = mesh["primitives"][0]
    position = first["targets"][1]["POSITION"]  # other points, so that the two differ
    other = {"attributes": first["attributes"] | {"POSITION": position}, "indices": first["indices"]}
    mesh["primitives"].append(other | {"targets": first["targets"][::-1]})
    mesh["extras"] = {"targetNames": None if names == "null" else names} if names else None
    file = write(tmp_path / "a.gltf", content)
    rest = load_body(file=file)
    shown = {"smile,puff": ("smile", "puff"), "smile,smile": ("smile#0", "smile#1")}
    assert rest.shapes.names == shown.get(",".join(names or ()), ("target0", "target1"))
    for frame in (8, 16, 24):  # weights 0.5 and 0.5, 1 and 0, 1.5 and -0.5
        pose = load_motion(rest, Time(frame, 24.0), (), file=file, at=0)
        points = load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=file, at=0).points
        np.testing.assert_allclose(skin(rest, pose).points, points, atol=1e-6)


@pytest.mark.filterwarnings("error")
def test_meshes_of_several_skins_with_a_shared_joint_move_as_the_file_does(tmp_path):
    content = morphing([0.0, 0.0])
    content["nodes"][1]["children"].append(3)
    content["nodes"] += [
        {"name": "third", "translation": [1, 0, 0], "rotation": [0.6, 0.0, 0.0, 0.8], "children": [4]},
        {"name": "fourth", "rotation": [0.0, 0.6, 0.0, 0.8]},
        {"mesh": 0, "skin": 1, "name": "apart"},
        {"mesh": 0, "skin": 2, "name": "between"},
    ]
    inverse = content["skins"][0]["inverseBindMatrices"]  # first that of 1, as of skins without any
    content["skins"] += [{"joints": [3, 4]}, {"joints": [3, 2], "inverseBindMatrices": inverse}]
    file = write(tmp_path / "a.gltf", content)
    rest = load_body(file=file)
    for frame in (0, 9, 24):
        pose = load_motion(rest, Time(frame, 24.0), (), file=file, at=0)
        points = load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=file, at=0).points
        np.testing.assert_allclose(skin(rest, pose).points, points, atol=1e-6)


def test_weights_come_smoothly_from_rest_to_those_that_the_shot_begins_with(tmp_path):
    file = write(tmp_path / "a.gltf", morphing([0.5, -0.25]))
    rest = load_body(file=file)
    fps = 240.0
    poses = [load_motion(rest, Time(n, fps), (), file=file, at=0, settle=1.0) for n in range(-240, 1)]
    weights, rates = (np.array([getattr(pose, name) for pose in poses]) for name in ("weights", "weight_rates"))
    np.testing.assert_allclose(weights[[0, -1]], [[0.5, -0.25], [0.0, 1.0]], atol=1e-9)
    np.testing.assert_allclose((weights[2:] - weights[:-2]) * (fps / 2), rates[1:-1], atol=0.02)
    np.testing.assert_allclose(rates[-1], [1.5, -1.5], atol=1e-5)
    assert np.abs(rates[120]).min() > 0.5


def only_buffer(folder: Path, uri: str) -> Path:
    """Write a file with one buffer."""
    content = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": 4}]}
    (folder / "a.gltf").write_text(json.dumps(content))
    return folder / "a.gltf"


@pytest.mark.parametrize(
    ("uri", "message"),
    [
        ("pipe", "it is a pipe"),
        ("zero", "outside of its folder"),
        ("../secret", "outside of its folder"),
        ("%2e%2e/secret", "outside of its folder"),
        ("/etc/passwd", "outside of its folder"),
        ("a%00b", "cannot exist"),
        ("none", "No such file"),
    ],
)
def test_a_buffer_is_a_file_in_the_folder_of_its_document(tmp_path: Path, uri: str, message: str):
    folder = tmp_path / "inside"
    folder.mkdir()
    (tmp_path / "secret").write_bytes(b"1234")
    (folder / "zero").symlink_to("/dev/zero")
    os.mkfifo(folder / "pipe")
    with pytest.raises(BadInput, match=message):
        list_files(only_buffer(folder, uri))


def test_a_json_of_too_many_items_is_refused_before_it_is_parsed(tmp_path: Path):
    (tmp_path / "a.gltf").write_bytes(b"[" + b"[]," * 3_000_000 + b"0]")
    with pytest.raises(BadInput, match=r"its JSON has 6,000,00\d items"):
        list_files(tmp_path / "a.gltf")
