"""`hairpipe usd check` says one line a finding and tells scripts by its exit code."""

import json
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from hairpipe.formats.usd.shot import Shot, write_shot
from hairpipe.values import Strands


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A stage with no fault."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/a").GetPrim())
    stage.Save()
    return tmp_path / "a.usda"


def spoil(file: Path) -> None:
    text = file.read_text()
    assert "metersPerUnit = 1" in text
    file.write_text(text.replace("metersPerUnit = 1", "metersPerUnit = -1"))


def test_each_finding_is_one_line_and_a_good_stage_has_none(file, hairpipe) -> None:
    result = hairpipe(f"usd check {file}")
    assert (result.exit_code, result.output) == (0, "")
    spoil(file)
    result = hairpipe(f"usd check {file}")
    assert result.exit_code == 1
    assert result.stdout == "error: metres-per-unit: /: metersPerUnit is -1; it has to be positive\n"


def test_output_is_one_json_document(file, hairpipe) -> None:
    for bad in (False, True):
        if bad:
            spoil(file)
        result = hairpipe(f"usd check --json {file}")
        document = json.loads(result.stdout)
        assert result.exit_code == bad and document["file"] == str(file)
        assert [finding["rule"] for finding in document["findings"]] == ["metres-per-unit"] * bad


def test_an_unreadable_file_is_code_2_and_a_message(file, hairpipe) -> None:
    file.write_text("#usda 1.0\n{")
    result = hairpipe(f"usd check {file}")
    assert result.exit_code == 2 and not result.stdout
    assert result.stderr.startswith(f"hairpipe: {file}: not a readable USD file: line 2, column 1")


def test_differences_and_notes_keep_the_exit_code(tmp_path, hairpipe) -> None:
    curves = np.linspace(0.0, 0.2, 4 * 24).reshape(-1, 1) * [[1.0, 0.5, 0.0]]
    offsets = np.arange(0, 97, 4, dtype=np.int32)
    for name, width in (("old", 8e-5), ("new", 9e-5)):
        strands = Strands(curves.astype(np.float32), np.zeros((96, 3), np.float32), offsets, width)
        write_shot(tmp_path / f"{name}.usdc", Shot({1: strands}, None, None, 24.0))
    result = hairpipe(f"usd check {tmp_path}/new.usdc --since {tmp_path}/old.usdc --for karma --json")
    found = json.loads(result.stdout)["findings"]
    assert {(f["rule"], f["severity"]) for f in found} >= {("widths", "change"), ("karma-unshown", "note")}
    assert result.exit_code == any(f["severity"] in ("error", "warning") for f in found)
    result = hairpipe(f"usd check {tmp_path}/new.usdc --since {tmp_path}/none.usdc")
    assert result.exit_code == 2 and "none.usdc" in result.stderr
