"""Planted differences of a head from its earlier version are named, with their sizes; nothing else is."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from hairpipe.formats.usd.check.changes import compare
from hairpipe.formats.usd.check.scene import Finding
from tests.formats.usd.check.test_defects import Plant, all_of, edit, meta, put, strands

SAME = "the settings are the same"


@pytest.fixture
def since(tmp_path: Path, written: Path) -> Path:
    return Path(shutil.copy(written / "shot.usdc", tmp_path / "earlier.usdc"))


def differences(head: Usd.Stage, since: Path, plant: Plant) -> list[Finding]:
    plant(head)
    head.Save()
    return compare(Path(head.GetRootLayer().realPath), since)


def setting(node: str, **settings: object) -> Plant:
    """Plant other settings of a node in the graph that the head states."""

    def plant(stage: Usd.Stage) -> None:
        key = f"hairpipe:nodes:{node}"
        fields = json.loads(stage.GetDefaultPrim().GetCustomDataByKey(key))
        text = json.dumps(fields | {"settings": fields["settings"] | settings})
        stage.GetDefaultPrim().SetCustomDataByKey(key, text)

    return plant


def half(stage: Usd.Stage) -> None:
    """Plant a head with the first half of its strands."""
    for name in ("points", "velocities", "widths", "pref"):
        edit(f".{name}", lambda p: p[: len(p) // 2])(stage)
    for name in ("curveVertexCounts", "hairId", "st", "skinprim", "skinprimuv"):
        edit(f".{name}", lambda p: p[: len(p) // 2])(stage)


def raised(pref: np.ndarray) -> np.ndarray:
    """Move the strand 4 up by 5 mm."""
    return pref + 0.005 * ((np.arange(len(pref)) // 6) == 4)[:, None] * [0, 1, 0]


PLANTED: dict[str, tuple[Plant, dict[str, str]]] = {
    "nothing": (lambda _: None, {}),
    "a root at rest": (edit(".pref", raised), {"roots": "1 of 30 roots moved, the strand 104 by 5 mm"}),
    "lengths": (
        edit(".pref", lambda p: 1.5 * p - 0.5 * p.reshape(30, 6, 3)[:, :1].repeat(6, 1).reshape(-1, 3)),
        {"lengths": "30 of 30 strands differ, 200 -> 300 mm in the median; ratio"},
    ),
    "widths": (edit(".widths", lambda w: 2 * w), {"widths": "30 of 30 strands differ, 0.08 -> 0.16 mm"}),
    "a frame": (
        strands(lambda s: s + 0.002 * (np.arange(30) == 7)[:, None, None] * [0.0, 0, 1], 1004),
        {"motion": "1 of 30 strands move differently from 1004 on, the strand 107 by 2 mm"},
    ),
    "strands": (half, {"count": "30 -> 15 strands: 0 new, 15 gone", "bounds": "the hair fills"}),
    "ids": (edit(".hairId", lambda i: i[::-1]), {"roots": "ids name other strands than before"}),
    "the body": (
        edit("body.points", lambda p: p + 0.001, 1003),
        {"body": "moves differently from 1003 on, by up to 1.73 mm"},
    ),
    "the range": (lambda s: s.SetEndTimeCode(1006), {"stage": "endTimeCode 1008.0 -> 1006.0"}),
}
"""Differences: plant, and the beginning of the message by rule."""


@pytest.mark.parametrize(("plant", "expected"), PLANTED.values(), ids=PLANTED)
def test_names_a_difference_and_nothing_else(head, since, plant, expected):
    found = {f.rule: f.message for f in differences(head, since, plant)}
    assert SAME in found.pop("settings")
    if "bounds" not in expected:
        found.pop("bounds", None)  # of whatever moves
    assert found.keys() == expected.keys()
    assert all(found[rule].startswith(text) for rule, text in expected.items()), found


def test_names_the_settings_that_moved_the_hair_and_how_to_undo_it(head, since):
    other = all_of(setting("hair", gravity=8.0), setting("usd", hairs=100), strands(lambda s: s + 0.001, 1004))
    found = differences(head, since, other)
    settings = [f.message for f in found if f.rule == "settings"]
    assert settings == ["hair.gravity absent -> 8.0", "usd.hairs 900 -> 100"]
    (motion,) = (f for f in found if f.rule == "motion")
    assert str(motion.cause) == "from hair.gravity = 8.0: write hair.gravity = absent to undo"
    assert motion.time == 1004 and sum(motion.values.values()) == pytest.approx(3**0.5 * len(motion.values), rel=1e-3)


def test_points_are_compared_in_metres(head, since):
    scaled = meta(metersPerUnit=0.01)
    hundred = [edit(f".{name}", lambda p: 100 * p) for name in ("points", "pref", "widths")]
    found = differences(head, since, all_of(scaled, *hundred, edit("body.points", lambda p: 100 * p)))
    assert [(f.rule, f.message) for f in found if f.rule != "settings"] == [("stage", "metersPerUnit 1.0 -> 0.01")]


def test_a_file_without_its_graph_is_compared_all_the_same(head, since):
    plant = all_of(lambda s: s.GetDefaultPrim().ClearCustomData(), put(".widths", [8e-5] * 90 + [9e-5] * 90))
    found = {f.rule: f.message for f in differences(head, since, plant)}
    assert found["settings"] == "unknown: this file does not state its graph"
    assert found["widths"].startswith("15 of 30 strands differ")
