"""Redraws of the viewport upload nothing, in one call for all strands."""

import pytest

from hairpipe.graphs.experiments.bench.pictures.redraw import measure_redraw

from .test_page import needs_browser


@needs_browser
@pytest.mark.slow
def test_a_redraw_uploads_nothing_in_one_draw_call():
    (found,) = measure_redraw(200, 5, 1).tables["redraw"]
    assert (found["strands"], found["redraw uploads [bytes]"], found["draw calls"]) == (200, 0, 1)
    assert found["frame uploaded [bytes]"] >= 200 * 5 * 10 and found["redraw [ms]"] > 0.0
