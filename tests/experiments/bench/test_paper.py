"""Shares of a frame by thread."""

import pytest

from hairpipe.graphs.experiments.bench.paper import serial_shares


def row(scene, threads, **seconds):
    return {"scene": scene, "first frame": 6, "threads": threads} | {f"{k} [s]": v for k, v in seconds.items()}


def test_serial_shares_are_those_that_amdahls_law_was_given():
    def frame(threads):
        return row("head", threads, body=2.0 * (0.1 + 0.9 / threads), search=1.0, grid=0.0)

    found = serial_shares([frame(1), row("other", 2, body=1.0), frame(2), frame(16)])
    assert [case["threads"] for case in found] == [2, 16]
    for case in found:
        assert case["body [%]"] == pytest.approx(10.0)
        assert case["search [%]"] == pytest.approx(100.0)
        assert case["all [%]"] == pytest.approx(100.0 * (2.0 * 0.1 + 1.0) / 3.0)
        assert "grid [%]" not in case
