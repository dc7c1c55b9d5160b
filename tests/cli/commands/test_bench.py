"""`hairpipe bench`: the reports as tables."""

import os

from hairpipe.bench import first_use, paper
from hairpipe.bench.machine import Machine
from hairpipe.graph.run.kernel_cache import TABLE

MACHINE = Machine("A Processor", 2, {"numba": "1.2"})


def test_the_table_of_the_paper_stands_beside_ours(monkeypatch, hairpipe, tmp_path):
    monkeypatch.setenv(TABLE, os.environ[TABLE])
    given = {}

    def measure(say, scenes, cache, overrides, moving):
        given.update(scenes=scenes, overrides=overrides, moving=moving)
        shares = {"strands": 1.5, "search": 2.5}
        rows = [
            paper.Row(name, 99, 1234, 0.25, 4.25, shares, 2_500_000_000, paper.PRINTED.get(name)) for name in scenes
        ]
        return paper.Report(MACHINE, rows)

    monkeypatch.setattr(paper, "measure_paper", measure)
    scenes = ("long_curly", "hundred_thousand_25")
    text = hairpipe(
        f"bench paper {' '.join(scenes)} --moving 20 --set groom.strands=99 --set hair.scheme=bdf2 --cache {tmp_path}"
    ).stdout
    assert (
        given["moving"] == 20
        and given["overrides"] == {"groom.strands": "99", "hair.scheme": "bdf2"}
        and [*given["scenes"]] == [*scenes]
    )
    assert all(path.is_file() for path in given["scenes"].values())
    lines = [line.split() for line in text.splitlines()]
    assert ["long_curly", "99", "25%", "1,234", "4.2", "2.5", "GB", "250,000", "240"] in lines
    assert ["hundred_thousand_25", "99", "25%", "1,234", "4.2", "2.5", "GB"] in lines
    assert ["long_curly", "1.5", "2.5"] in lines


def test_first_use_lists_functions_of_several_specialisations(hairpipe, monkeypatch):
    given = []
    report = first_use.Report(MACHINE, 113.0, 5.1, {"sim.pcg._turn": 2, "sim.axis.gather": 1})
    monkeypatch.setattr(
        first_use, "measure_first_use", lambda path, overrides: given.append((path, overrides)) or report
    )
    text = hairpipe("bench first-use tune/short_slow --set groom.strands=9").stdout
    assert given[0][0].name == "short_slow.toml" and given[0][1] == {"groom.strands": "9"}
    assert "113.0 processor seconds without kernels, 5.1 with them" in text
    assert "3 kernels of 2 functions" in text and "_turn" in text and "gather" not in text
