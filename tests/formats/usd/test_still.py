"""One value as a stage, as a whole shot would hold it."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.shot import write_still


@pytest.fixture(params=["hair", "body", "groom"])
def value(request, shot):
    return shot.groom if request.param == "groom" else getattr(shot, request.param)[1003]


def test_our_strict_check_finds_nothing(value, tmp_path):
    write_still(tmp_path / "still.usda", value, 1003, 24.0)
    assert lint(tmp_path / "still.usda", lambda path: []) == []


def test_the_points_stand_at_the_one_frame(value, tmp_path):
    write_still(tmp_path / "still.usdc", value, 1003, 24.0)
    stage = Usd.Stage.Open(str(tmp_path / "still.usdc"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (1003, 1003, 24)
    (prim,) = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointBased)]
    attribute = UsdGeom.PointBased(prim).GetPointsAttr()
    assert attribute.GetTimeSamples() == [1003]
    np.testing.assert_array_equal(attribute.Get(1003), np.float32(value.points))
