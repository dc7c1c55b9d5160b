"""The report on pictures."""

from pathlib import Path

import pytest

from hairpipe.graphs.experiments.bench.pictures import picture
from hairpipe.render import exposure, portrait, shadows
from hairpipe.render.cycles import process
from hairpipe.render.raster import lines
from hairpipe.render.shading import kajiya_kay


@pytest.mark.kernels
def test_parts_of_a_picture_are_all_of_it(monkeypatch):
    monkeypatch.setattr(process, "find_spec", lambda name: None)
    said = []
    report = picture.measure_picture(said.append, picture.Sizes(hair=((60, 6), (30, 9)), times=2))
    assert said[:2] == ["60 strands of 6 points", "30 strands of 9 points"]
    assert "Blender is not installed" in said[-1] and report.locks == []
    assert [(case.strands, case.points) for case in report.cases] == [(60, 6), (30, 9)]
    for case in report.cases:
        assert tuple(case.shares) == picture.PARTS and min(case.shares.values()) >= 0.0
        assert case.shares["shadows"] > 0.0 and sum(case.shares.values()) == pytest.approx(case.seconds, rel=0.1)
        assert case.deep > case.shares["shadows"] and case.knots >= 2.0


def test_files_are_the_parts_that_they_say():
    modules = (lines, kajiya_kay, shadows, portrait, exposure)
    named = [picture.part_of(Path(module.__file__)) for module in modules]
    assert named == ["hair", "light on hair", "shadows", "film", "film"]
