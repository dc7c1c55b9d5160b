"""The report on hair as a volume."""

import numba
import numpy as np
import pytest

from hairpipe.graphs.experiments.bench import volume
from hairpipe.values.groom import strand_lengths


def test_every_case_is_measured_once():
    before, reported = numba.get_num_threads(), []
    report = volume.measure_volume(reported.append, hairs=200, segments=6, every=2, seconds=0.0)
    assert numba.get_num_threads() == before and reported == ["100 hairs on a grid", "200 hairs between 100 keys"]
    threads = [n for n in volume.THREADS if n <= before]
    kernels = ("grid", "pressure", "interpolate")
    assert [(case["kernel"], case["threads"]) for case in report.tables["kernels"]] == [
        (name, n) for name in kernels for n in threads
    ]
    assert all(0 < case["low [ns]"] <= case["median [ns]"] <= case["high [ns]"] for case in report.tables["kernels"])


def test_hair_is_as_long_as_it_says():
    groom = volume.scattered_hair(5, 7)
    assert strand_lengths(groom.points, groom.offsets) == pytest.approx(np.full(5, volume.LENGTH))
