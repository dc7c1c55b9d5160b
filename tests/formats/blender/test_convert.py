"""Files of other programs, converted by Blender, and read by our nodes."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.formats.blender import convert
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_mesh_cache import load_mesh_cache

from ..blender_tube import RIG, TUBE

CHARACTER = """
import sys, bpy, numpy as np
folder = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.frame_start, scene.frame_end, scene.render.fps = 1, 4, 24
"""
SAVED = """
for frame in (1, 4):
    bend(frame, 0.2, 0.1)
shown = shown_at(range(1, 5))
scene.frame_set(1)
bpy.ops.export_scene.fbx(filepath=f"{folder}/tube.fbx", add_leaf_bones=False, bake_anim_simplify_factor=0.0)
bpy.ops.export_scene.gltf(filepath=f"{folder}/tube.glb")
bpy.context.preferences.filepaths.save_version = 0
bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/tube.blend")
np.save(f"{folder}/shown.npy", np.array(shown)[..., [0, 2, 1]] * (1, 1, -1))
"""


@pytest.fixture(scope="module")
def folder(blender, tmp_path_factory) -> Path:
    """Files of a tube that bends, and what Blender shows of it at frames 1 to 4, y up."""
    folder = tmp_path_factory.mktemp("converted")
    done = subprocess.run(
        [sys.executable, "-c", CHARACTER + TUBE + RIG + SAVED, folder], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".fbx", ".blend", ".glb"])
def test_a_skinned_body_moves_as_before(folder, suffix):
    made = folder / f"{suffix[1:]}.usdc"
    convert(folder / f"tube{suffix}", made)
    shown = np.load(folder / "shown.npy")
    rest = load_body(file=made)
    for frame in range(1, 5):
        mesh = load_mesh_cache(Time(frame, 24.0), (), rest=rest, file=made, at=1)
        far = np.linalg.norm(mesh.points[:, None] - shown[frame - 1], axis=2)
        assert max(far.min(axis=0).max(), far.min(axis=1).max()) < 1e-5
    assert {path.name for path in folder.iterdir()} >= {made.name} and not list(folder.glob(".convert-*"))


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
