"""Tables of measured values as people read them."""

from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.report import Report
from hairpipe.graphs.experiments.commands.measured import show, written

CASES = [{"scene": "curls", "strands": 12_345, "frame [s]": 4.256}, {"scene": "wind", "frame [s]": 0.0123}]


def test_every_table_is_written_below_the_machine(capsys):
    show(Report("bench", Machine("A Processor", 2, {"numba": "1.2"}), {"frames": CASES}))
    machine, versions, _, title, heads, first, second = capsys.readouterr().out.splitlines()
    assert (machine, versions, title) == ("A Processor, 2 cores", "numba 1.2", "frames")
    assert heads.split("  ") == ["scene", "strands", "frame [s]"]
    assert first.split() == ["curls", "12,345", "4.26"]
    assert second.split() == ["wind", "0.0123"], "what a case does not have is empty"


def test_fractions_have_three_significant_digits():
    given = [1234.5, 117.46, 0.25, 0.0, float("inf"), 7, "text", None]
    assert [written(value) for value in given] == ["1,234", "117", "0.250", "0.0", "inf", "7", "text", ""]
