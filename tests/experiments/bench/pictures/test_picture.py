"""The report on pictures."""

from pathlib import Path

import pytest

from hairpipe.graphs.experiments.bench.pictures import picture
from hairpipe.render import cycles as process
from hairpipe.render import film as exposure
from hairpipe.render import kajiya_kay, lines, portrait, shadows


@pytest.mark.kernels
def test_parts_of_a_picture_are_all_of_it(monkeypatch):
    monkeypatch.setattr(process, "find_spec", lambda name: None)
    reported = []
    report = picture.measure_picture(reported.append, ((60, 6), (30, 9)), 2)
    assert reported[:2] == ["60 strands of 6 points", "30 strands of 9 points"]
    assert "Blender is not installed" in reported[-1] and [*report.tables] == ["pictures"]
    cases = report.tables["pictures"]
    assert [(case["strands"], case["points"]) for case in cases] == [(60, 6), (30, 9)]
    for case in cases:
        shares = {part: case[f"{part} [s]"] for part in picture.PARTS}
        assert min(shares.values()) >= 0.0 < shares["shadows"] < case["with deep shadows [s]"]
        assert sum(shares.values()) == pytest.approx(case["whole [s]"], rel=0.1) and case["knots a texel"] >= 2.0


def test_files_are_the_parts_that_they_say():
    modules = (lines, kajiya_kay, shadows, portrait, exposure)
    named = [picture.part_of(Path(module.__file__)) for module in modules]
    assert named == ["hair", "light on hair", "shadows", "film", "film"]
