"""`hairpipe bench`: arguments and tables."""

import os

from hairpipe.engine.worker.machine_code import TABLE
from hairpipe.graphs.experiments.bench import paper
from hairpipe.graphs.experiments.bench.engine import first_use
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.report import Report

MACHINE = Machine("A Processor", 2, {"numba": "1.2"})


def test_table_has_the_values_of_the_paper(monkeypatch, hairpipe, tmp_path):
    monkeypatch.setenv(TABLE, os.environ[TABLE])
    given = {}

    def measure_scene(echo, path, store, overrides, settling, threads):
        given.update({path.stem: path}, overrides=overrides, moving=settling)
        for count in threads:
            case = {"strands": 99, "first frame": 21, "threads": count, "frame [s]": 4.25 / count}
            yield case, {"strands": 1.5, "search": 2.5}

    monkeypatch.setattr(paper, "measure_scene", measure_scene)
    scenes = ("long_curly", "hundred_thousand_25")
    text = hairpipe(
        f"bench paper {' '.join(scenes)} --moving 20 --threads 1 --threads 2 --set groom.strands=99 --cache {tmp_path}"
    ).stdout
    assert given["moving"] == (20,) and given["overrides"] == {"groom.strands": "99"}
    assert all(given[scene].is_file() for scene in scenes)
    lines = [line.split() for line in text.splitlines()]
    ours = [line for line in lines if line[:2] == ["long_curly", "99"]]
    assert [(*line[2:5], *line[6:]) for line in ours] == [
        ("21", "1", "4.25", "250,000", "240"),
        ("21", "2", "2.12", "250,000", "240"),
    ]
    assert ["hundred_thousand_25", "99", "21", "1", "4.25"] in [line[:5] for line in lines if len(line) == 6]
    assert ["long_curly", "21", "2", "1.50", "2.50"] in lines


def test_first_use_is_measured_on_a_shipped_graph(hairpipe, monkeypatch):
    given = []

    def measure(path, overrides):
        given.append((path, overrides))
        return Report("first_use", MACHINE, {"first use": [{"with kernels [processor s]": 5.1}]})

    monkeypatch.setattr(first_use, "measure_first_use", measure)
    text = hairpipe("bench first-use tune/short_slow --set groom.strands=9").stdout
    assert given[0][0].name == "short_slow.toml" and given[0][1] == {"groom.strands": "9"}
    assert "with kernels [processor s]" in text and "5.10" in text
