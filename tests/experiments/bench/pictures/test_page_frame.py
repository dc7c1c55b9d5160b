"""Parts of the time from an edit on the page to a new frame."""

import time
from itertools import islice, repeat
from types import SimpleNamespace
from typing import Any

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.pictures import page_frame


def measured_tables(path, target) -> list[list[dict[str, Any]]]:
    """Tables of a report."""
    return [*page_frame.measure_page_frame(str(path), {}, target, "sum").tables.values()]


@pytest.mark.slow
def test_parts_of_an_edit_are_its_whole(shot, monkeypatch):
    monkeypatch.setattr(page_frame, "REPEATS", 1)
    monkeypatch.setattr(page_frame, "browser_path", lambda: None)
    wholes = []

    def timed(*given):
        begun = time.monotonic()
        moments = asked(*given)
        wholes.append((moments[-1] - moments[0], time.monotonic() - begun))
        return moments

    asked = page_frame.ask
    monkeypatch.setattr(page_frame, "ask", timed)
    pages, server = measured_tables(shot.path, "seed.value")
    parts = {case["part"]: case["time [s]"] for case in pages}
    assert parts.keys() > {
        page_frame.EDITED,
        page_frame.ASKED,
        page_frame.BEGUN,
        "node seed",
        "node move",
        "node sum",
        page_frame.RECEIVED,
        page_frame.SHOWN,
    }
    whole, around = wholes[-1]
    assert sum(parts.values()) == pytest.approx(whole, abs=1e-6) and whole <= around
    assert sum(case["share [%]"] for case in pages) == pytest.approx(100.0)
    assert all(case["processor [s]"] > 0.0 for case in server)
    with pytest.raises(BadInput, match="not a number"):
        measured_tables(shot.path, "seed.nothing")
    with monkeypatch.context() as patch:
        patch.setattr(page_frame, "values_of", lambda *given: repeat("3"))  # as it is
        begun = time.monotonic()
        with pytest.raises(BadInput, match=r"seed\.value = 3: no new frame"):
            measured_tables(shot.path, "seed.value")
        assert time.monotonic() - begun < 0.5 * page_frame.PATIENCE
    monkeypatch.setattr(page_frame, "PATIENCE", 0.0)
    with pytest.raises(BadInput, match=r"move\.turn = 1001: no new frame"):
        measured_tables(shot.path, "move.turn")


def test_numbers_of_edits_are_all_different(shot):
    def values(target, **settings):
        draft: Any = SimpleNamespace(shot=SimpleNamespace(graph=shot.load(**settings)))
        return [float(text) for text in islice(page_frame.values_of(draft, target), 9)]

    for value in (0.0, -2.5, 1000.0):
        assert len({value, *values("seed.value", seed__value=value)}) == 10
    assert values("move.turn", move__turn=0) == [*range(1, 10)]


def test_an_edit_without_a_new_result_is_refused():
    shot = SimpleNamespace(plan=lambda *frames, to: SimpleNamespace(records={}))
    session: Any = SimpleNamespace(frames=None, draft=SimpleNamespace(shot=shot))
    with pytest.raises(BadInput, match=r"seed\.value: the edit changes no result of 'sum'"):
        page_frame.measured(session, lambda text: [0.0] * 5, page_frame.Way("sum", 1, "seed.value"), "2")
