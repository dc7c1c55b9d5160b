"""A groom with guides, imported into Blender as a user does it, and looked at by Blender itself."""

import ast
import json
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.blender import job_of, make_scene, script_of
from hairpipe.nodes.export_groom import export_groom
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import take

STRANDS, POINTS = 12, 5
LOOK = """
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
    points = (roots[:, None] + np.linspace(0, 0.05, POINTS)[None, :, None] * np.array([0, 1, 0])).reshape(-1, 3)
    sites = np.zeros(STRANDS, np.int32), np.tile((1.0, 0, 0), (STRANDS, 1)), np.tile(np.eye(3, 4), (STRANDS, 1, 1))
    offsets = (POINTS * np.arange(STRANDS + 1)).astype(np.int32)
    groom = Groom(points, offsets, np.arange(STRANDS, dtype=np.int32), *sites, np.zeros((STRANDS, 2), np.float32))
    still = np.zeros((STRANDS * POINTS, 3), np.float32)
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
    command = [sys.executable, "-c", LOOK, str(tmp_path / "scene.blend")]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    found, times, tip = json.loads(output.partition("FOUND")[2])
    assert found == {"hair": [False, "ShaderNodeBsdfHairPrincipled"], "guides": [True, "ShaderNodeBsdfHairPrincipled"]}
    assert times == [1001, 1002, 30.0]
    x, y, z = points[4]
    assert np.allclose(tip, (x, -z, y), atol=1e-6), "Blender's vertical axis is Z"
