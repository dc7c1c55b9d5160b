"""The bench of hair next to busy programs."""

import time

from hairpipe.graphs.experiments.bench import busy


def test_every_case_is_measured_next_to_so_many_processes(monkeypatch):
    seen = []

    def median_frame(hairs, before, frames):
        time.sleep(0.05)
        seen.append(hairs)
        return 2.0 * len(seen), 3.0 * len(seen)

    monkeypatch.setattr(busy, "median_frame", median_frame)
    said = []
    rows = busy.measure_busy(said.append, [60, 100], [0, 2]).tables["busy"]
    assert [(row["hairs"], row["busy processes"]) for row in rows] == [(60, 0), (60, 2), (100, 0), (100, 2)]
    assert [row["frame to first"] for row in rows] == [1.0, 2.0, 1.0, 4 / 3]
    assert said[1] == "60 hairs next to 2 busy processes"


def test_frames_are_timed_in_another_process():
    wall, processor = busy.median_frame(20, 1, 1)
    assert wall > 0.0 and processor > 0.0


def test_processes_compute_until_the_context_ends():
    with busy.computing(2) as others:
        assert all(other.poll() is None for other in others)
    assert all(other.poll() is not None for other in others)
