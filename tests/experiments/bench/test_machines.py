"""The benches `machines` and `parity`: they find what is wrong, and that nothing is, in short."""

from pathlib import Path

import pytest

from hairpipe.formats.hdf5 import digest_file
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.machines import parity, trials
from hairpipe.graphs.experiments.bench.machines.fault_list import FAULTS, Fault, do_nothing

MACHINE = Machine("A Processor", 2, {"numba": "1.2"})
BY_TITLE = {fault.title: fault for fault in FAULTS}


def test_faults_are_of_all_kinds_and_have_different_names():
    assert len(BY_TITLE) == len(FAULTS) >= 30
    assert {fault.during for fault in FAULTS} >= {"make_seed None", "move_seed 3", "add_up 4", "write_list None", ""}


@pytest.mark.parametrize(
    ("codes", "lines", "extra", "found"),
    [
        ([1, 0], ["a", "b"], 1, []),
        ([0], [], 0, ["exit code 0 in place of 1"]),
        ([1, 1], [], 1, ["a later run fails"]),
        ([1, None], [], 1, ["a run does not end within 240 s"]),
        ([1, 0], [], 2, ["2 evaluations more than undisturbed, 1 lost"]),
        ([1, 0], [], -1, ["-1 evaluations more than undisturbed, 1 lost"]),
        ([1, 0], ["a", "b", "c"], 0, ["3 lines in place of 2"]),
    ],
)
def test_violations_are_named(codes, lines, extra, found):
    fault = Fault("child killed", "local", "add_up 4", do_nothing, lost=1, code=1, lines=2)
    assert trials.violations_of(fault, codes, lines, extra) == found


def test_messages_contain_no_port_and_no_folder_of_a_trial():
    message = "move@1: tcp://127.0.0.1:4321 has another store, or none, at /a/hairpipe-machines-x1/1/store (mount)"
    assert trials.without_places(message) == "move@1: tcp://127.0.0.1 has another store, or none, at ... (mount)"
    assert trials.without_places("No space left on device: '/a/hairpipe-machines-x1/store/h.part'") == (
        "No space left on device: '...'"
    )


@pytest.mark.slow
def test_faults_end_as_required_and_a_loss_that_is_not_allowed_is_found():
    killed = BY_TITLE["local, frame of a scan: child killed"]
    stale = BY_TITLE["local, frame of a scan: two runs, one with stale listings"]
    said = []
    report = trials.try_machines(said.append, digest_file, [killed, stale, killed._replace(lost=0)])
    first, second, third = report.tables["faults"]
    assert (first["violation"], second["violation"]) == ("", ""), report
    assert third["violation"] == "1 evaluations more than undisturbed, 0 lost" and not trials.held(report)
    assert (first["exit code"], first["next exit codes"], first["lines"]) == (1, "0", 2)


def test_a_fault_that_this_machine_does_not_allow_is_not_tried(monkeypatch, tmp_path):
    def refuse(fault, folder):
        raise OSError("no")

    monkeypatch.setattr(Fault, "scene", refuse)
    case = trials.try_fault(FAULTS[0], tmp_path, trials.Truth({}, 0), digest_file)
    assert case is None and trials.verdict_of(case) == "not tried"


WEDGE = """schema = 1
frames = [1, 3]
fps = 24
tuft = { type = "make_strands", strands = 2, length = 0.1, segments = 3, direction = [0.0, -1.0, 0.0] }
shake = { type = "drive_ends", in.groom = "tuft", at = 1, wave = { turning = 90.0, frequency = 2.0 } }
[wedge.sixteen]
axes.tuft.length = [0.1, 0.2]
"""


@pytest.mark.slow
def test_ways_agree_and_a_difference_is_found(tmp_path, monkeypatch):
    graph = tmp_path / "wedge.toml"
    graph.write_text(WEDGE)
    monkeypatch.setattr(parity, "FRAMES", "1-3")

    def run_less(way):
        monkeypatch.setattr(parity, "FRAMES", "1-2")
        parity.run_here(way)

    ways = {"run": parity.run_here, "shuffled": parity.run_shuffled, "less": run_less}
    report = parity.compare_ways(lambda line: None, digest_file, graph, ways)
    first, second, third = report.tables["ways"]
    assert first["violation"] == second["violation"] == "" and second["commands"] > 1
    assert first["evaluated"] == second["evaluated"] > 4
    assert third["violation"] == "other results; other objects; other counts" and not parity.agree(report)


def test_parity_without_openjd_is_one_message(monkeypatch):
    from hairpipe.errors import BadInput

    monkeypatch.setattr(parity, "OPENJD", Path("/absent"))
    with pytest.raises(BadInput, match="openjd is not installed"):
        parity.compare_ways(print, digest_file)
