"""Reports on pictures, and on what a browser takes for a page."""

import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.pictures import picture
from hairpipe.graphs.experiments.bench.pictures.luminance import COLOURS, measure_luminance
from hairpipe.graphs.experiments.bench.pictures.page import READY, measure_page
from hairpipe.graphs.experiments.bench.pictures.redraw import measure_redraw
from hairpipe.render import cycles as process
from hairpipe.render import film as exposure
from hairpipe.render import kajiya_kay, lines, portrait, shadows

needs_browser = pytest.mark.skipif(shutil.which("chromium") is None, reason="no browser: Debian's package chromium")


@needs_browser
@pytest.mark.slow
def test_work_of_the_browser_is_counted(tmp_path):
    idle = "<script>document.body.dataset.state = 'ready'</script>"
    # In a function, whose variables are compiled; each turn needs the one before: about two seconds.
    work = "const work = () => { let x = 0; for (let i = 0; i < 2e9; i++) x = Math.imul(x, 31) + i | 0; return x };"
    busy = f"<script>{work} document.title = work();</script>"
    found = []
    for name, script in (("idle", idle), ("busy", busy + idle)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "index.html").write_text(f"<body>{script}</body>")
        found += measure_page(tmp_path / name).tables["page"]
    assert found[0]["files"] == 1 and found[0]["size [bytes]"] == len(f"<body>{idle}</body>")
    assert found[1]["opening [processor s]"] > found[0]["opening [processor s]"] + 0.7
    assert READY == 'data-state="ready"'


@needs_browser
@pytest.mark.slow
def test_a_page_that_does_not_become_ready_is_refused(tmp_path):
    (tmp_path / "index.html").write_text("<body>nothing</body>")
    with pytest.raises(BadInput, match="did not become ready"):
        measure_page(tmp_path)


def test_a_folder_without_a_report_is_refused(tmp_path):
    with pytest.raises(BadInput, match="holds no report"):
        measure_page(tmp_path)


@needs_browser
@pytest.mark.slow
def test_a_redraw_uploads_nothing_in_one_draw_call():
    (found,) = measure_redraw(200, 5, 1).tables["redraw"]
    assert (found["strands"], found["redraw uploads [bytes]"], found["draw calls"]) == (200, 0, 1)
    assert found["frame uploaded [bytes]"] >= 200 * 5 * 10 and found["redraw [ms]"] > 0.0


@pytest.mark.skipif(find_spec("bpy") is None, reason="Blender is not installed: no bpy for this Python")
def test_locks_are_about_as_bright_as_by_path_tracing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The darkest and the brightest."""
    monkeypatch.delitem(COLOURS, "brown")
    locks = measure_luminance(lambda _: None, samples=2)
    assert [lock.colour for lock in locks] == list(COLOURS)
    assert [lock.dual / lock.traced for lock in locks] == pytest.approx([1.0] * len(locks), abs=0.2)


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
