"""The lint is silent on what we write and on good stages, says when and how often, and looks at every clip."""

import dataclasses
import importlib
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdValidation, Vt

from hairpipe.apart import work_apart
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.shot import Shot, write_clips, write_shot
from hairpipe.formats.usd.stage import expand
from hairpipe.values import Strands

HAIR = "/shot/hair"


def folder(stage: Usd.Stage) -> Path:
    return Path(stage.GetRootLayer().realPath).parent


def test_silent_on_a_good_stage(stage: Usd.Stage, found: Callable) -> None:
    assert found(stage) == []


@pytest.mark.parametrize("write", [write_shot, write_clips])
@pytest.mark.parametrize("change", [{}, {"body": None, "groom": None}, {"fps": 24 / 1.001}, {"name": "take_2"}])
def test_silent_on_what_we_write(tmp_path: Path, shot: Shot, write: Callable, change: dict) -> None:
    write(tmp_path / "shot.usdc", dataclasses.replace(shot, **change))
    assert lint(tmp_path / "shot.usdc") == []


@pytest.mark.parametrize("write", [write_shot, write_clips])
def test_silent_on_a_cut_that_the_stage_notes(tmp_path: Path, shot: Shot, write: Callable) -> None:
    def leapt(frame: int) -> Strands:
        hair = shot.hair[frame]
        return dataclasses.replace(hair, points=hair.points + np.float32(2.0 * (frame >= 1003)))

    hair = {frame: leapt(frame) for frame in shot.hair}
    leap = dataclasses.replace(shot, hair=hair, body=None, groom=None)
    write(tmp_path / "cut.usdc", dataclasses.replace(leap, cuts=(1003,)))
    write(tmp_path / "torn.usdc", dataclasses.replace(leap, name="torn"))
    assert [finding.rule for finding in lint(tmp_path / "cut.usdc")] == []
    assert "velocity-match" in [finding.rule for finding in lint(tmp_path / "torn.usdc")]


@pytest.mark.parametrize("write", [write_shot, write_clips])
def test_so_are_the_validators_of_usd(tmp_path: Path, shot: Shot, write: Callable) -> None:
    write(tmp_path / "shot.usdc", shot)
    stage = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert [e.GetErrorAsString() for e in UsdValidation.ValidationContext(validators).Validate(stage)] == []


def test_silent_on_frames_on_twos_and_on_shutter_samples(tmp_path: Path, shot: Shot, found: Callable) -> None:
    twos = {frame: shot.hair[frame] for frame in (1001, 1003, 1005)}
    write_shot(tmp_path / "twos.usdc", dataclasses.replace(shot, hair=twos, body=None))
    stage = Usd.Stage.Open(str(tmp_path / "twos.usdc"))
    for name in ("points", "velocities", "extent"):
        attribute = stage.GetAttributeAtPath(f"{HAIR}.{name}")
        values = {time: attribute.Get(time) for time in (1002.75, 1003.25)}
        for time, value in values.items():
            attribute.Set(value, time)
    assert found(stage) == []


def test_finding_has_first_time_and_count(stage: Usd.Stage) -> None:
    points = stage.GetAttributeAtPath(f"{HAIR}.points")
    for time in (1003, 1004):
        broken = np.array(points.Get(time))
        broken[28:] = np.nan
        points.Set(Vt.Vec3fArray.FromNumpy(broken), time)
    stage.Save()
    (finding,) = lint(Path(stage.GetRootLayer().realPath))
    assert (finding.time, finding.count, finding.severity) == (1003, 2, "error")
    assert str(finding) == (
        "error: finite: /shot/hair.points @ 1003: element 28 of curve 5 is not finite; 2 such [2 times]"
    )


CLIP = [f"./shot.clips/shot.{frame}.usdc" for frame in range(1001, 1009)]


def change_file(name: str, data: bytes | None) -> Callable:
    """Plant other bytes of a file of the clips, or none."""

    def plant(stage: Usd.Stage) -> None:
        path = folder(stage) / "shot.clips" / name
        path.unlink() if data is None else path.write_bytes(data)

    return plant


def set_clips(**fields: object) -> Callable:
    """Plant other metadata of the clips; None takes a field away."""

    def plant(stage: Usd.Stage) -> None:
        api = Usd.ClipsAPI(stage.GetDefaultPrim())
        changed = {**api.GetClips()["default"], **fields}
        api.SetClips({"default": {name: value for name, value in changed.items() if value is not None}})

    return plant


def undeclared(stage: Usd.Stage) -> None:
    layer = Sdf.Layer.FindOrOpen(str(folder(stage) / "shot.clips" / "shot.manifest.usdc"))
    hair = layer.GetPrimAtPath(HAIR)
    hair.RemoveProperty(hair.properties["velocities"])
    layer.Save()


def empty(stage: Usd.Stage) -> None:
    change_file("shot.1003.usdc", (folder(stage) / "shot.clips" / "shot.manifest.usdc").read_bytes())(stage)


def files(*names: str) -> Sdf.AssetPathArray:
    return Sdf.AssetPathArray([Sdf.AssetPath(name) for name in names])


CLIPS: list[tuple[str, str, Callable[[Usd.Stage], object]]] = [
    ("missing", "missing-file", change_file("shot.1003.usdc", None)),
    ("damaged", "broken-layer", change_file("shot.1003.usdc", b"PXR-USDC")),
    ("manifest missing", "missing-file", change_file("shot.manifest.usdc", None)),
    ("no manifest", "clip-manifest", set_clips(manifestAssetPath=None)),
    ("empty", "clip-values", empty),
    ("manifest without velocities", "clip-undeclared velocities", undeclared),
    ("two clips swapped", "clip-times", set_clips(assetPaths=files(CLIP[1], CLIP[0], *CLIP[2:]))),
    ("clip left out", "clip-times", set_clips(assetPaths=files(*CLIP[:3], *CLIP[4:]))),
    ("clip one late", "clip-times", set_clips(active=Vt.Vec2dArray([(1002 + i, i) for i in range(8)]))),
    ("clip never played", "clip-times", set_clips(active=Vt.Vec2dArray([(1001 + i, 0) for i in range(8)]))),
    ("another prim", "clip-undeclared", set_clips(primPath="/take")),
    ("above the folder", "absolute-path", set_clips(manifestAssetPath=Sdf.AssetPath(f"../all{CLIP[0][1:]}"))),
]


@pytest.mark.parametrize(("name", "rules", "plant"), CLIPS, ids=[name for name, *_ in CLIPS])
def test_names_defects_of_clips(clips: Usd.Stage, found: Callable, name: str, rules: str, plant: Callable) -> None:
    plant(clips)
    assert set(rules.split()) <= {rule for rule, _ in found(clips)}


def test_silent_on_clips_and_on_what_they_flatten_to(clips: Usd.Stage, found: Callable, tmp_path: Path) -> None:
    assert found(clips) == []
    clips.Flatten().Export(str(tmp_path / "flat.usda"))
    assert lint(tmp_path / "flat.usda") == []


@pytest.mark.parametrize("rate", [24.0, 30.0])
def test_a_clip_of_another_rate_is_found_though_nothing_has_opened_it(clips, found, rate: float) -> None:
    path = folder(clips) / "shot.clips" / "shot.1005.usdc"
    clip = Sdf.Layer.OpenAsAnonymous(str(path))
    clip.timeCodesPerSecond = clip.framesPerSecond = rate
    clip.Export(str(path))
    Sdf.Layer.FindOrOpen(str(path)).Reload(True)
    assert found(clips) == [("clip-rates", "/shot")] * (rate != 24.0)


@pytest.mark.parametrize("last", [1005, 1006])
def test_counts_the_files_of_a_template(tmp_path: Path, shot: Shot, found: Callable, last: int) -> None:
    write_clips(tmp_path / "shot.usdc", shot)
    stage = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    api = Usd.ClipsAPI(stage.GetDefaultPrim())
    manifest = Sdf.AssetPath("./shot.clips/shot.manifest.usdc")
    api.SetClips({"default": {"primPath": "/shot", "manifestAssetPath": manifest}})
    api.SetClipTemplateAssetPath("./shot.clips/shot.####.usdc")
    api.SetClipTemplateStartTime(1001)
    api.SetClipTemplateEndTime(last)
    api.SetClipTemplateStride(1)
    assert found(stage) == [("missing-file", "/shot")] * (last - 1005)


def test_templates_name_their_files() -> None:
    assert list(expand("a/h.####.usdc", 9, 11, 1)) == ["a/h.0009.usdc", "a/h.0010.usdc", "a/h.0011.usdc"]
    assert list(expand("h.##.##.usd", 1, 2, 0.5)) == ["h.01.00.usd", "h.01.50.usd", "h.02.00.usd"]
    assert list(expand("h.usd", 1, 2, 1)) == []
    assert len(list(expand("h.#.usd", 0, 1e300, 1e-300))) < 200_000


def test_a_missing_box_is_a_warning(head: Usd.Stage) -> None:
    head.GetPrimAtPath(HAIR).RemoveProperty("extent")
    head.Save()
    findings = lint(folder(head) / "shot.usdc")
    assert [(f.rule, f.severity) for f in findings] == [("extent", "warning")]


def test_a_type_that_two_layers_disagree_with_is_one_finding(head: Usd.Stage) -> None:
    for name in ("a.usda", "b.usda"):
        layer = Sdf.Layer.CreateNew(str(folder(head) / name))
        Sdf.AttributeSpec(Sdf.CreatePrimInLayer(layer, HAIR), "orientation", Sdf.ValueTypeNames.String)
        layer.Save()
        head.GetRootLayer().subLayerPaths.append(f"./{name}")
    head.Save()
    (finding,) = lint(folder(head) / "shot.usdc")
    assert (finding.rule, finding.path, finding.count) == ("attribute-type", f"{HAIR}.orientation", 2)
    assert "'token'" in finding.message and "'string'" in finding.message


def test_no_validator_waits_for_a_pipe(head: Usd.Stage) -> None:
    for name in ("pipe.usda", "pipe.png"):
        os.mkfifo(folder(head) / name)
        attribute = head.GetPrimAtPath(HAIR).CreateAttribute(f"userProperties:{name[5:]}", Sdf.ValueTypeNames.Asset)
        attribute.Set(Sdf.AssetPath(f"./{name}"))
    head.Save()
    assert [finding.rule for finding in lint(folder(head) / "shot.usdc")] == ["missing-file", "missing-file"]


def test_validators_run_on_one_thread_of_the_child(tmp_path: Path, written: Path, monkeypatch) -> None:
    """The library of linear algebra has threads of its own unless it is told not to."""
    code = """
import os
from hairpipe.formats.usd.check.lint import lint

def count_threads(path):
    assert lint(path) == []
    return len(os.listdir("/proc/self/task"))
"""
    (tmp_path / "counting_of_threads.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    module = importlib.import_module("counting_of_threads")
    assert work_apart(module.count_threads, written / "shot.usdc") == 1
