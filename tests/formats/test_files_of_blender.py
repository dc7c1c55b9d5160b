"""Files that Blender writes: hair curves as Alembic and USD, a skinned body as UsdSkel, read by our nodes."""

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from hairpipe.body.skinning import skin
from hairpipe.engine import Time
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_groom import load_groom
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from hairpipe.nodes.load_motion import load_motion

from .blender_tube import RIG, TUBE

HAIR = """
import sys, bpy, numpy as np
folder = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.frame_start, scene.frame_end, scene.render.fps = 1, 4, 24
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
"""
BODY = """
for frame in (1, 4):
    bend(frame, 0.2, 0.1)  # bent in the first frame, the pose of rest
shown = shown_at(range(1, 5))
scene.frame_set(1)
bpy.ops.wm.usd_export(filepath=f"{folder}/tube.usdc", export_animation=True, export_armatures=True)
y_up = lambda points: np.array(points)[..., [0, 2, 1]] * (1, 1, -1)
np.savez(f"{folder}/truth.npz", hair=y_up(strands), tube=y_up(shown), radii=radii)
"""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(blender, tmp_path_factory) -> Path:
    """Files of Blender, and in truth.npz what Blender shows: points of strands and body, and radii."""
    folder = tmp_path_factory.mktemp("blender")
    done = subprocess.run([sys.executable, "-c", HAIR + TUBE + RIG + BODY, folder], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return folder


@pytest.mark.parametrize("suffix", [".abc", ".usdc"])
def test_hair_has_the_points_and_widths_that_blender_shows(folder, suffix):
    truth = np.load(folder / "truth.npz")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        groom = load_groom(
            load_body(file=folder / "tube.usdc"), file=folder / f"hair{suffix}", points="file", reach=1.0
        )
    assert groom.offsets.tolist() == [0, 4, 10, 13]
    np.testing.assert_allclose(groom.points, truth["hair"], atol=1e-6)
    np.testing.assert_allclose(groom.widths, 2 * truth["radii"], rtol=1e-6)
    if suffix == ".usdc":  # Blender writes no attributes to Alembic
        assert groom.maps["clump"].tolist() == [0.25, 0.5, 1.0]


def test_a_skinned_body_moves_as_blender_shows(folder):
    file = folder / "tube.usdc"
    truth, rest = np.load(folder / "truth.npz")["tube"], load_body(file=file)
    assert rest.bound is not None and rest.skeleton.names == ("upper", "lower") and np.ptp(truth, axis=0).max() > 0.3
    for frame in (2, 4):
        time, shown = Time(frame, 24.0), truth[frame - 1]
        np.testing.assert_allclose(load_mesh_cache(time, (), rest=rest, file=file, at=1).points, shown, atol=1e-6)
        np.testing.assert_allclose(skin(rest, load_motion(rest, time, (), file=file, at=1)).points, shown, atol=1e-6)
