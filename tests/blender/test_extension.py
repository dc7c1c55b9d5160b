"""The extension of Blender, as Blender runs it: in processes of the module bpy, in the background."""

import ast
import json
import os
import re
import subprocess
import sys
import time
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import hairpipe
from hairpipe.app.api.node_types import describe
from hairpipe.blender.extension_zip import FOLDER, contents, write_extension
from hairpipe.errors import BadInput

HERE = Path(__file__).resolve().parents[2]
FIRST, STILL, LAST = 1001, 1016, 1024
"""Frames of the scenes of `in_blender`: in the end a keyframe is set at the last."""
Y_UP_TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """Folder with the files of the extension as a package that needs no installation."""
    folder = tmp_path_factory.mktemp("package")
    (folder / "hairpipe_extension").mkdir()
    for name, data in contents(describe).items():
        (folder / "hairpipe_extension" / name).write_bytes(data)
    return folder


def start_case(name: str, folder: Path, package: Path | str) -> subprocess.Popen[str]:
    """Start a case of `in_blender`, with the hairpipe of this environment."""
    given = os.environ | {"HAIRPIPE": os.fspath(Path(sys.executable).with_name("hairpipe"))}
    line = [sys.executable, "-m", "tests.blender.in_blender", name, folder, package]
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=given, cwd=HERE)


def case(name: str, folder: Path, package: Path | str) -> dict[str, Any]:
    """Run a case of `in_blender`, and return what it found."""
    child = start_case(name, folder, package)
    said, _ = child.communicate()
    assert child.returncode == 0, said[-3000:]
    return json.loads(said.strip().splitlines()[-1])


@pytest.fixture(scope="module")
def simulated(blender, package, tmp_path_factory) -> tuple[Path, dict[str, Any]]:
    """A scene that was simulated twice, in the folder, and what was seen of it."""
    folder = tmp_path_factory.mktemp("shot")
    return folder, case("simulate", folder, package)


def test_the_zip_has_a_manifest_and_always_the_same_bytes(tmp_path):
    for name in ("one.zip", "other.zip"):
        write_extension(tmp_path / name, describe)
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "other.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "one.zip") as archive:
        assert {"__init__.py", "blender_manifest.toml", "declaration.json"} <= {*archive.namelist()}
        assert f'version = "{hairpipe.__version__}"' in archive.read("blender_manifest.toml").decode()
    with pytest.raises(BadInput, match=r"right: \.zip|\.zip"):
        write_extension(tmp_path / "one.tar", describe)


def test_it_imports_what_blender_has_and_nothing_of_hairpipe():
    """Blender 4.2 has Python 3.11, NumPy, and no package of ours."""
    allowed = {*sys.stdlib_module_names, "bpy", "mathutils", "numpy"}
    for path in FOLDER.glob("*.py"):
        for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 11))):
            names = [alias.name for alias in item.names] if isinstance(item, ast.Import) else []
            if isinstance(item, ast.ImportFrom) and not item.level:
                names = [item.module or ""]
            assert {name.partition(".")[0] for name in names} <= allowed, path.name


@pytest.mark.slow
def test_blender_validates_it_and_installs_it(blender, tmp_path):
    write_extension(tmp_path / "hairpipe.zip", describe)
    spec = find_spec("bpy")
    assert spec is not None and spec.origin is not None
    program = next(Path(spec.origin).parent.rglob("bl_pkg/cli/blender_ext.py"))
    line = [sys.executable, program, "validate", tmp_path / "hairpipe.zip"]
    done = subprocess.run(line, capture_output=True, text=True)
    assert done.returncode == 0 and "Success" in done.stdout, done.stdout
    install = (
        "import bpy, sys\n"
        "give = dict(filepath=sys.argv[1], repo='user_default', enable_on_install=True)\n"
        "for _ in range(2):\n"
        "    bpy.ops.extensions.package_install_files(**give)\n"
        "    print(bpy.types.Object.bl_rna.properties['hairpipe'].name)\n"
        "bpy.ops.preferences.addon_disable(module='bl_ext.user_default.hairpipe')\n"
        "print('hairpipe' in bpy.types.Object.bl_rna.properties)\n"
    )
    line = [sys.executable, "-c", install, tmp_path / "hairpipe.zip"]
    own = os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "user")}
    done = subprocess.run(line, capture_output=True, text=True, env=own)
    assert done.returncode == 0 and done.stdout.strip().endswith("False"), done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.kernels
def test_curves_of_the_result_are_where_the_pipeline_has_them(simulated):
    """At frames, and at half frames, between which Blender moves points on lines; in metres, with Z up."""
    folder, found = simulated
    shot = hairpipe.load(next(folder.rglob("shot.toml")), cache=folder / "mit ä blank" / "hairpipe" / "cache")
    assert shot.fps == pytest.approx(25 / 1.001)

    def expected(moment: float) -> np.ndarray:
        low = int(moment)
        ends = [shot.get(f"shown_hair@{frame}").points for frame in (low, min(low + 1, LAST))]
        return ((1.0 - (moment - low)) * ends[0] + (moment - low) * ends[1]) @ Y_UP_TO_Z_UP.T

    for moment, places in found["places"].items():
        if float(moment) < STILL:  # later a keyframe was changed
            np.testing.assert_allclose(np.array(places), expected(float(moment)), atol=1e-6)
    first, last = (np.array(found["places"][str(frame)]) for frame in (FIRST, LAST))
    changed = np.array(found["changed places"])
    np.testing.assert_allclose(changed, expected(LAST), atol=1e-6)
    assert np.abs(last - first).max() > 0.02 and np.abs(changed - last).max() > 0.005


@pytest.mark.slow
@pytest.mark.kernels
def test_a_result_has_what_the_original_has_and_hides_it(simulated):
    _, found = simulated
    assert {"position", "radius", "velocity", "clump", "id"} <= {*found["attributes"]}
    np.testing.assert_allclose(found["clump"], np.linspace(0.1, 1.0, 12), rtol=1e-6)
    assert found["radius"] == pytest.approx(5e-5) and found["material"] == ["Brown"] and found["surface"] == "Head"
    assert found["hidden"] and found["modifier"] == "//hairpipe/shot/hair/hair.usdc"
    assert found["frame"] == FIRST + 2
    assert found["renamed"] == ["Hair simulated", "Renamed"]
    assert found["shown again"] and found["left"] == ["Renamed"] and found["blocks"] == [1, 0]


@pytest.mark.slow
@pytest.mark.kernels
def test_the_panel_says_how_many_frames_would_run(simulated):
    """Frames up to the one before the body moves otherwise stand, from the last state that is kept on."""
    _, found = simulated
    assert found["first"][0] == f"Frames to simulate: {FIRST}-{LAST}"
    assert found["second"] == ["Nothing to compute: the result is current"]
    begin, end = map(int, re.findall(r"\d+", found["changed"][0]))
    assert STILL - 8 <= begin <= STILL and end == LAST


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.kernels
def test_a_farm_renders_the_saved_scene_without_the_extension(simulated):
    folder, _ = simulated
    assert not case("render", folder, "none")["extension"]
    picture = np.asarray(Image.open(folder / "picture.png").convert("L"), float)
    assert picture.std() > 5.0


@pytest.mark.slow
@pytest.mark.kernels
def test_two_grooms_pins_and_colliders_of_a_turned_scene_in_centimetres(blender, package, tmp_path):
    found = case("scene_of_all", tmp_path, package)
    for part in (
        *("[groom_hair]", "[groom_fringe]", "[collider_garment]", 'in.sheets = "collider_garment"'),
        *('type = "pin_hair"', "speed = 2.0", f"frames = [{FIRST - 2}, {LAST}]", "at = [1.0]"),
    ):
        assert part in found["graph"], part
    assert found["hand"]
    for name, seen in found["results"].items():
        assert seen["roots"] < 1e-4, name  # in centimetres: 1 um
    free = found["results"]["Fringe"]["tips"]
    assert free[0] > 0.5 and abs(free[2]) < free[0]  # gravity points along X


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.kernels
def test_old_particle_hair_becomes_curves_that_are_simulated(blender, package, tmp_path):
    found = case("particles", tmp_path, package)
    assert sorted(found["curves"].values()) == [[20, False, 1], [20, True, 0]] and not found["drawn"], found


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.kernels
def test_nothing_is_lost_when_blender_is_killed(blender, package, tmp_path):
    """States are kept at some frames: a run goes on after the last of them."""
    child = start_case("long_run", tmp_path, package)
    deadline = time.monotonic() + 120.0
    while len([*tmp_path.rglob("live/*/*")]) < 30 and child.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    child.kill()
    child.wait()
    lines = case("plan_again", tmp_path, package)["lines"]
    begin, end = map(int, re.findall(r"\d+", lines[0]))
    assert begin > FIRST and end == FIRST + 99


FAULTS = {
    "unsaved": "Hair: save the file first",
    "no surface": "Hair: Hair has no surface: pick a body",
    "no map": "no attribute and no vertex group 'nowhere'",
    "no list": "profile: steep is not a list",
    "no pins": "Hair has no attribute 'nowhere'",
    "linked": "Hair is linked: make a library override",
    "instances": "Head has instances: realize them",
    "no curves": "Hair has no curve of two or more points",
    "far": "Hair: ",
    "absent": "there is no object 'Nobody'",
    "no program": "there is no hairpipe; state its path",
    "old program": "speaks protocol 99, and this extension protocol 1",
}
"""Part of the message of each case of `in_blender.faults`."""


@pytest.mark.slow
@pytest.mark.kernels
def test_a_window_shows_frames_as_they_arrive_and_esc_stops_a_run(blender, package, tmp_path):
    found = case("modal", tmp_path, package)
    answer, curves, _, _, left, _, lines = found["stopped"]
    assert (answer, curves, left, lines[-1]) == ("CANCELLED", ["Hair"], 0, None)
    answer, curves, seen, shown, left, known, lines = found["whole"]
    assert (answer, left, lines[-1]) == ("FINISHED", 0, None) and sorted(curves) == ["Hair", "Hair simulated"]
    assert seen == pytest.approx(shown, abs=1e-6) and "Esc: stop" in lines[-2]
    assert known == [["Nothing to compute: the result is current"], True]


@pytest.mark.slow
def test_faults_of_a_scene_end_in_one_line(blender, package, tmp_path):
    found = case("faults", tmp_path, package)
    assert found.keys() == FAULTS.keys()
    for name, part in FAULTS.items():
        assert part in found[name] and "\n" not in found[name].strip(), f"{name}: {found[name]}"


@pytest.mark.slow
def test_panels_show_all_settings_and_presets_are_what_they_say(blender, package, tmp_path):
    found = case("interface", tmp_path, package)
    for name, (wanted, given) in found["presets"].items():
        assert given == wanted, name
    rows = {row for rows in found["panels"].values() for row in rows}
    for label in ("Diameter (um)", "Reach (mm)", "Preset", "Pins", "Frequency (Hz)", "Voxel (mm)", "Wind of the Scene"):
        assert label in rows, label
    assert len(rows) > 80


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.kernels
def test_a_command_simulates_a_scene_without_a_screen(simulated, tmp_path):
    """It saves the result where it is told to, and finds what the extension has computed."""
    folder, _ = simulated
    shot, output = folder / "mit ä blank" / "shot.blend", folder / "mit ä blank" / "farm.blend"
    before = shot.read_bytes()
    program = Path(sys.executable).with_name("hairpipe")
    done = subprocess.run(
        [program, "blender", shot, "--simulate", "Hair", "-o", output], capture_output=True, text=True
    )
    assert done.returncode == 0 and done.stdout.strip() == str(output), done.stderr
    assert "Frame" in done.stderr and shot.read_bytes() == before and output.is_file()
    done = subprocess.run([program, "blender", shot, "--simulate", "Wig"], capture_output=True, text=True)
    assert done.returncode == 2 and "there is no object 'Wig'" in done.stderr and "Traceback" not in done.stderr
