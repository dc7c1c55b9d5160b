"""Bytes of a scan through the store."""

import pytest

from hairpipe.engine.store.store import Output, Record
from hairpipe.graphs.experiments.bench.engine.traffic import measure_traffic, traffic_of


def test_frames_write_their_results_and_the_state_at_the_checkpoint(shot):
    """Four frames, of which the last is a checkpoint; sizes are those of the files of a run that keeps all states."""
    shot.path.write_text(shot.path.read_text().replace("checkpoint = 4", "checkpoint = 1").replace("[1, 10]", "[1, 4]"))
    shot.run()
    size = shot.store.size
    numbers, states = ([size(shot.results()[f"sum@{f}"][name]) for f in range(1, 5)] for name in ("number", "state"))
    inputs = [size(shot.results()[f"move@{frame}"][""]) for frame in range(2, 5)]
    shot.path.write_text(shot.path.read_text().replace("checkpoint = 1", "checkpoint = 4"))
    lines = []
    (case,) = measure_traffic(lines.append, {"toy": shot.path}, {}, "sum").tables["traffic"]
    assert (lines, case["graph"], case["frames"]) == (["toy"], "toy", 4)
    assert case["written with every state [MB]"] == pytest.approx(1e-6 * sum(numbers + states) / 4)
    assert case["written [MB]"] == pytest.approx(1e-6 * (sum(numbers) + states[3]) / 4)
    assert case["read [MB]"] == pytest.approx(1e-6 * sum(inputs) / 3)


def test_a_link_carries_as_many_as_its_bytes_a_second_divided_by_theirs():
    """A frame of 4 s on one of two cores writes 5 MB and reads 2.5 MB that are new: 2.5 MB/s, of 125 and 1,250."""
    names = [f"{number:040x}.h5" for number in range(4)]
    outputs = {"strands": Output(names[0], 5_000_000), "state": Output(names[3], 40_000_000)}
    inputs = [{"body": [names[1], names[2]], "groom": names[3], "previous": names[0]}]
    inputs.append({"body": [names[2], names[0]], "groom": names[3], "surface": None, "previous": names[1]})
    records = [Record("", "hair", 1, {"inputs": found}, outputs, "state", 9.0, (), 0.0, 4.0) for found in inputs]
    case = traffic_of(records, set(names[:3]), dict.fromkeys(names, 2_500_000), cores=2)
    assert case["written [MB]"] == 5.0 and case["read [MB]"] == 2.5 and case["written with every state [MB]"] == 45.0
    assert (case["simulations on 1 Gbit/s"], case["simulations on 10 Gbit/s"]) == (50.0, 500.0)
