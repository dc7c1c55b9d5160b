"""`hairpipe usd check` says one line a finding and tells scripts by its exit code."""

import json
from pathlib import Path

import pytest
from pxr import Usd, UsdGeom


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
