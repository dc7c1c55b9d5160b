"""`hairpipe wedge`, and `run` and `plan` with `--wedge`."""

import json

import pytest

WEDGE = """
[weight]
type = "weigh"
in.number = "sum"
[wedge.steps] # of the movement
axes.move.step = [1.0, 2.0]
measures = ["weight"]
stop = [["weight.weight [kg]", ">", 35]]
"""


@pytest.fixture
def wedged(shot):
    shot.write_text(shot.read_text() + WEDGE)
    return shot


def test_a_wedge_is_planned_run_compared_and_promoted(wedged, hairpipe):
    assert hairpipe("wedge list shot.toml").stdout == "steps: 2 variants of move.step\n  step=1\n  step=2\n"
    assert "move[step=2]     1-6  depends on seed" in hairpipe("plan shot.toml --wedge steps").stdout
    result = hairpipe("run shot.toml --wedge steps -j1")
    assert result.exit_code == 0 and "stopped: step=2: weight.weight [kg] 38.57 > 35 at frame 5" in result.stdout
    document = json.loads(hairpipe("run shot.toml --wedge steps -j1 --json").stdout)
    assert document["evaluated"] == 0 and list(document["stopped"]) == ["step=2"]
    assert json.loads(hairpipe("plan shot.toml --wedge steps --json").stdout)["stopped"] == document["stopped"]
    table = json.loads(hairpipe("wedge table shot.toml steps --json").stdout)
    assert [row["variant"] for row in table["variants"]] == ["step=1", "step=2"]
    assert "| step | mean weight [kg] |" in hairpipe("wedge table shot.toml steps --markdown").stdout
    assert "stopped" in hairpipe("wedge table shot.toml steps").stdout
    before = wedged.read_text()
    assert hairpipe("wedge promote shot.toml steps step=2").stdout == "move.step = 2.0\n"
    assert wedged.read_text() == before.replace('in.seed = "seed"\n', 'in.seed = "seed"\nstep = 2.0\n')


def test_wedges_are_data_too(wedged, hairpipe):
    found = json.loads(hairpipe("wedge list shot.toml --json").stdout)["wedges"]["steps"]
    assert found["axes"] == {"move.step": [1.0, 2.0]} and found.keys() == {"axes", "variants"}
    assert found["variants"] == {"step=1": {"move.step": 1.0}, "step=2": {"move.step": 2.0}}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("run shot.toml --wedge step", "no wedge 'step' (did you mean 'steps'?)"),
        ("plan shot.toml --wedge other", "no wedge 'other' (known: steps)"),
        ("wedge table shot.toml step", "no wedge 'step' (did you mean 'steps'?)"),
        ("wedge promote shot.toml steps step=3", "'steps' has no variant 'step=3' (did you mean 'step=2'?)"),
        ("wedge sheet shot.toml steps -o .", "is a folder"),
        ("wedge sheet shot.toml steps -o x.png", "no picture is shown"),
    ],
)
def test_a_fault_is_one_message(wedged, hairpipe, arguments, message):
    result = hairpipe(arguments)
    assert result.exit_code == 2 and message in result.stderr and len(result.stderr.splitlines()) == 1


def test_names_are_completed(wedged, hairpipe, monkeypatch):
    def completed(words):
        monkeypatch.setenv("COMP_WORDS", words)
        monkeypatch.setenv("COMP_CWORD", str(len(words.split(" ")) - 1))
        monkeypatch.setenv("_HAIRPIPE_COMPLETE", "zsh_complete")
        return hairpipe("").stdout.split("\n")[1::3]

    assert completed("hairpipe run shot.toml --wedge s") == ["steps"]
    assert completed("hairpipe wedge promote shot.toml steps st") == ["step=1", "step=2"]
