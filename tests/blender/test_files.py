"""Files that Blender writes or converts, compared with what Blender shows; and grooms that it imports."""

import ast
import json
import subprocess
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from hairpipe.blender.programs import convert, job_of, make_scene, script_of
from hairpipe.body.skinning import skin
from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.nodes.export_groom import export_groom
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_groom import load_groom
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.nodes.load_motion import load_motion
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import take

SCRIPT = """
import sys, bpy, numpy as np
folder = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.frame_start, scene.frame_end, scene.render.fps = 0, 12, 24
y_up = lambda points: np.array(points)[..., [0, 2, 1]] * (1, 1, -1)

hair = bpy.data.hair_curves.new("hair")
hair.add_curves([4, 6, 3])
count = len(hair.points)
points = np.random.default_rng(0).random((count, 3)) * 0.1
hair.attributes["position"].data.foreach_set("vector", points.ravel().astype(np.float32))
radii = np.linspace(1e-4, 2e-4, count)
hair.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", radii.astype(np.float32))
hair.attributes.new("clump", "FLOAT", "CURVE").data.foreach_set("value", np.array([0.25, 0.5, 1.0], np.float32))
item = bpy.data.objects.new("hair", hair)
item.location, item.rotation_euler = (0.1, 0.2, 0.3), (0.4, 0.0, 0.2)
scene.collection.objects.link(item)
bpy.context.view_layer.update()
strands = [item.matrix_world @ point.position for point in hair.points]
bpy.ops.wm.alembic_export(filepath=f"{folder}/hair.abc", start=1, end=1)
bpy.ops.wm.usd_export(filepath=f"{folder}/hair.usdc")
bpy.data.objects.remove(item)

bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.2, depth=2, location=(0, 0, 1), end_fill_type="TRIFAN")
tube = bpy.context.object
bpy.ops.object.transform_apply(location=True)
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.subdivide(number_cuts=2)
bpy.ops.object.mode_set(mode="OBJECT")
bpy.ops.object.armature_add()
rig = bpy.context.object
bpy.ops.object.mode_set(mode="EDIT")
upper = rig.data.edit_bones[0]
upper.name, upper.head, upper.tail = "upper", (0, 0, 0), (0, 0, 1)
lower = rig.data.edit_bones.new("lower")
lower.head, lower.tail, lower.parent = (0, 0, 1), (0, 0, 2), upper
bpy.ops.object.mode_set(mode="OBJECT")
for name in ("upper", "lower"):
    tube.vertex_groups.new(name=name)
for vertex in tube.data.vertices:
    share = min(max(vertex.co.z - 0.5, 0.0), 1.0)
    tube.vertex_groups["upper"].add([vertex.index], 1.0 - share, "REPLACE")
    tube.vertex_groups["lower"].add([vertex.index], share, "REPLACE")
tube.parent = rig
tube.modifiers.new("skin", "ARMATURE").object = rig
for bone in rig.pose.bones:
    bone.rotation_mode = "XYZ"
for frame in (0, 12):
    rig.pose.bones["lower"].rotation_euler.x = 0.09 * frame + 0.1  # bent in the first frame, the pose of rest
    rig.pose.bones["upper"].rotation_euler.y = 0.05 * frame
    rig.pose.bones["upper"].location.x = 0.04 * frame
    for bone in rig.pose.bones:
        bone.keyframe_insert("rotation_euler", frame=frame)
        bone.keyframe_insert("location", frame=frame)

def shown():
    points = []
    for frame in range(13):
        scene.frame_set(frame)
        seen = tube.evaluated_get(bpy.context.evaluated_depsgraph_get())
        points.append([seen.matrix_world @ vertex.co for vertex in seen.data.vertices])
    scene.frame_set(0)
    return y_up(points)

def save_gltf(name):
    path = f"{folder}/{name}.glb"
    bpy.ops.export_scene.gltf(filepath=path, export_animation_mode="SCENE", export_force_sampling=True)

bent = shown()
save_gltf("tube")
bpy.ops.wm.usd_export(filepath=f"{folder}/tube.usdc", export_animation=True, export_armatures=True)
bpy.ops.export_scene.fbx(filepath=f"{folder}/tube.fbx", add_leaf_bones=False, bake_anim_simplify_factor=0.0)
bpy.context.preferences.filepaths.save_version = 0
bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/tube.blend")
tube.shape_key_add(name="rest")
key = tube.shape_key_add(name="wide")
for point in key.data:
    point.co.x *= 1.5
for frame in (0, 12):
    key.value = frame / 12
    key.keyframe_insert("value", frame=frame)
save_gltf("wide")
bpy.ops.wm.alembic_export(filepath=f"{folder}/wide.abc", start=0, end=12)
np.savez(f"{folder}/truth.npz", hair=y_up(strands), tube=bent, wide=shown(), radii=radii)
"""


@pytest.fixture(scope="module")
def folder(blender, tmp_path_factory) -> Path:
    """Files of Blender, and in truth.npz what Blender shows: points of strands and of the tube at 13 frames, radii."""
    folder = tmp_path_factory.mktemp("blender")
    done = subprocess.run([sys.executable, "-c", SCRIPT, folder], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".abc", ".usdc"])
def test_hair_has_the_points_and_widths_that_blender_shows(folder, suffix):
    truth, body = np.load(folder / "truth.npz"), load_body(file=folder / "tube.usdc")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        groom = load_groom(body, file=folder / f"hair{suffix}", points="file", reach=1.0)
    assert groom.offsets.tolist() == [0, 4, 10, 13]
    np.testing.assert_allclose(groom.points, truth["hair"], atol=1e-6)
    np.testing.assert_allclose(groom.widths, 2 * truth["radii"], rtol=1e-6)
    if suffix == ".usdc":  # Blender writes no attributes to Alembic
        assert groom.maps["clump"].tolist() == [0.25, 0.5, 1.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "converted", "near"),
    [
        ("tube.usdc", False, 1e-6),
        ("tube.glb", False, 2e-5),
        ("wide.glb", False, 2e-5),
        ("wide.abc", False, 2e-6),
        ("tube.fbx", True, 1e-5),
        ("tube.blend", True, 1e-5),
        ("tube.glb", True, 1e-5),
    ],
)
def test_a_body_moves_as_blender_shows(folder, tmp_path, name, converted, near):
    file, truth = folder / name, np.load(folder / "truth.npz")[name.partition(".")[0]]
    if converted:
        convert(file, tmp_path / "made.usdc")
        assert [path.name for path in tmp_path.iterdir()] == ["made.usdc"]
        file = tmp_path / "made.usdc"
    rest = load_body(file=file)
    assert converted or len(rest.mesh.points) == truth.shape[1]  # welded: a glTF file has more
    clip = {"clip": "*"} if file.suffix == ".glb" else {}
    meshes = {
        frame: load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=file, at=0, **clip) for frame in (0, 5, 6, 12)
    }
    _, places = cKDTree(truth[0]).query(meshes[0].points)
    for frame, mesh in meshes.items():
        np.testing.assert_allclose(mesh.points, truth[frame][places], atol=near)
    np.testing.assert_allclose(meshes[6].velocities, (truth[7] - truth[5])[places] * 12, atol=1e-3)
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0.0, "triangles face outward"
    if name == "wide.abc":
        return
    assert set(rest.skeleton.names) == {"upper", "lower"}
    for frame in (0, 5, 12):
        posed = skin(rest, load_motion(rest, Time(frame, 24.0), (), file=file, at=0, **clip))
        np.testing.assert_allclose(posed.points, truth[frame][places], atol=near)
        np.testing.assert_allclose(posed.points, meshes[frame].points, atol=1e-9 if clip else 1e-6)
        closely = 1e-9 if clip else 1e-5
        closely = 5e-3 if name == "wide.glb" else closely  # a product of two slopes is not the slope of points
        np.testing.assert_allclose(posed.velocities, meshes[frame].velocities, atol=closely)


@pytest.mark.slow
def test_an_unreadable_file_leaves_an_earlier_result(blender, tmp_path):
    broken, made = tmp_path / "broken.fbx", tmp_path / "made.usdc"
    broken.write_bytes(b"Kaydara FBX Binary  \0 and nothing else")
    made.write_bytes(b"earlier")
    with pytest.raises(BadInput, match=r"broken\.fbx: Blender failed"):
        convert(broken, made)
    assert made.read_bytes() == b"earlier" and len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize(
    ("name", "made", "reported"),
    [
        ("body.max", "body.usd", r"body\.max: Blender does not read this format"),
        ("body.fbx", "body.usd", r"body\.fbx: the file cannot be read"),
        ("body.fbx", "body.fbx", r"it does not end like a USD file"),
    ],
)
def test_bad_input_is_reported_without_blender(tmp_path, name, made, reported):
    with pytest.raises(BadInput, match=reported):
        convert(tmp_path / name, tmp_path / made)
    assert not list(tmp_path.iterdir())


STRANDS, EACH = 12, 5
ASK = """
import bpy, json, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
scene = bpy.context.scene
curves = [item for item in scene.objects if item.type == "CURVES"]
found = {item.name: [item.hide_render, item.data.materials[0].node_tree.nodes[0].bl_idname] for item in curves}
hair = scene.objects["hair"].evaluated_get(bpy.context.evaluated_depsgraph_get())
tip = list(hair.matrix_world @ hair.data.points[4].position)
times = [scene.frame_start, scene.frame_end, scene.render.fps / scene.render.fps_base]
print("FOUND" + json.dumps([found, times, tip]))
"""


@pytest.fixture
def shot(tmp_path):
    generator = np.random.default_rng(0)
    roots = generator.random((STRANDS, 3)) * 0.1
    points = (roots[:, None] + np.linspace(0, 0.05, EACH)[None, :, None] * np.array([0, 1, 0])).reshape(-1, 3)
    sites = np.zeros(STRANDS, np.int32), np.tile((1.0, 0, 0), (STRANDS, 1)), np.tile(np.eye(3, 4), (STRANDS, 1, 1))
    offsets = (EACH * np.arange(STRANDS + 1)).astype(np.int32)
    groom = Groom(points, offsets, np.arange(STRANDS, dtype=np.int32), *sites, np.zeros((STRANDS, 2), np.float32))
    still = np.zeros((STRANDS * EACH, 3), np.float32)
    hair = Frames((1001, 1002), lambda f: Strands(points + (f - 1001), still, offsets, 1e-4))
    keys = take(groom, np.array([0, 6]))
    file = export_groom(groom, hair, keys, None, None, Time(1001, 30.0), Workspace(tmp_path), target="blender")
    return file.path, points


def test_purposes_materials_and_frames_are_found(shot):
    job = job_of(shot[0])
    assert job["frames"] == [1001.0, 1002.0, 30.0] and job["blend"] is None
    assert {name: prim["purpose"] for name, prim in job["prims"].items()} == {"hair": "default", "guides": "guide"}
    assert job["prims"]["hair"]["material"] == "hair" and job["prims"]["hair"]["look"]["ior"] == pytest.approx(1.55)


def test_script_has_the_constants_of_the_shot(shot):
    text = script_of(shot[0])
    line = next(line for line in text.splitlines() if line.startswith("JOB"))
    assert ast.literal_eval(line.partition(" = ")[2]) == job_of(shot[0])
    compile(text, "shot.py", "exec")


def test_missing_shot_is_reported(tmp_path):
    with pytest.raises(BadInput, match=r"none\.usd: the file cannot be read"):
        script_of(tmp_path / "none.usd")


@pytest.mark.slow
@pytest.mark.skipif(find_spec("bpy") is None, reason="no bpy in this environment")
def test_blender_hides_guides_and_draws_hair_with_its_shader(shot, tmp_path):
    path, points = shot
    make_scene(path, tmp_path / "scene.blend", None)
    command = [sys.executable, "-c", ASK, str(tmp_path / "scene.blend")]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    found, times, tip = json.loads(output.partition("FOUND")[2])
    assert found == {"hair": [False, "ShaderNodeBsdfHairPrincipled"], "guides": [True, "ShaderNodeBsdfHairPrincipled"]}
    assert times == [1001, 1002, 30.0]
    x, y, z = points[4]
    assert np.allclose(tip, (x, -z, y), atol=1e-6), "Blender's vertical axis is Z"
