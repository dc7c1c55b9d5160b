"""The lint is silent on what we write and on good stages, says when and how often, and looks at every clip."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdValidation, Vt

from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.shot import Shot, write_clips, write_shot
from hairpipe.formats.usd.stage import expand
from hairpipe.values import Strands

HAIR, BODY = "/shot/hair", "/shot/body"


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


CLIPS: dict[str, tuple[Callable[[Path, Usd.ClipsAPI], object], str]] = {
    "missing": (lambda f, _: (f / "shot.1003.usdc").unlink(), "missing-file"),
    "damaged": (lambda f, _: (f / "shot.1003.usdc").write_bytes(b"PXR-USDC"), "broken-layer"),
    "manifest missing": (lambda f, _: (f / "shot.manifest.usdc").unlink(), "missing-file"),
    "no manifest": (lambda _, api: api.SetClips({"default": no_manifest(api)}), "clip-manifest"),
    "empty": (lambda f, _: (f / "shot.1003.usdc").write_bytes((f / "shot.manifest.usdc").read_bytes()), "clip-values"),
}


def no_manifest(api: Usd.ClipsAPI) -> dict:
    return {key: value for key, value in api.GetClips()["default"].items() if key != "manifestAssetPath"}


@pytest.mark.parametrize(("plant", "rule"), CLIPS.values(), ids=CLIPS)
def test_names_defects_of_clips(tmp_path: Path, shot: Shot, plant: Callable, rule: str) -> None:
    write_clips(tmp_path / "shot.usdc", shot)
    stage = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    plant(tmp_path / "shot.clips", Usd.ClipsAPI(stage.GetDefaultPrim()))
    stage.Save()
    assert rule in {finding.rule for finding in lint(tmp_path / "shot.usdc")}


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
