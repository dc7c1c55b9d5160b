"""`hairpipe explain`: one result in full."""

import json


def test_a_result_that_is_there(computed, hairpipe):
    text = hairpipe("explain shot.toml sum@4").stdout
    assert text.startswith("sum@4: cached\n")
    assert "setting  warn      0" in text
    assert "input    previous" in text and "time     frame     4" in text
    assert "output state" in text and "computed 2" in text


def test_every_difference_is_named(computed, hairpipe):
    text = hairpipe("explain shot.toml move@2 --set move.turn=4 --set move.step=2").stdout
    assert text.startswith("move@2: will run\n  setting step 1.0 -> 2.0\n  setting turn 1000 -> 4\n")
    assert hairpipe("explain shot.toml move@2 --set seed.value=4").stdout == "move@2: depends on seed\n"


def test_a_document(computed, hairpipe):
    document = json.loads(hairpipe("explain shot.toml list --json").stdout)
    assert (document["status"], document["frame"], document["reasons"]) == ("cached", None, [])
    assert [frame for frame, _ in document["made_of"]["inputs"]["numbers"]] == [1, 2, 3, 4, 5, 6]
    assert document["outputs"][""]["size"] > 0 and document["outputs"][""]["kept"]


def test_a_frame_too_many_or_too_few_is_refused(shot, hairpipe):
    for name, message in (
        ("sum", "'sum' has a value per frame (sum@1)"),
        ("seed@1", "'seed' has one value for the shot (seed)"),
        ("sum.stat@2", "'sum' has no output 'stat' (did you mean 'state'?)"),
        ("sum@99", "frame 99 is outside the graph (frames 1-6)"),
        ("sum@x", "'sum@x' is not the name of a result"),
    ):
        result = hairpipe(f"explain shot.toml {name}")
        assert result.exit_code == 2 and message in result.stderr


def test_unkept_states_have_the_message_of_get(computed, hairpipe):
    """Of every third frame and the last they are."""
    for frame in range(1, 7):
        kept = frame in (3, 6)
        text = hairpipe(f"explain shot.toml sum@{frame}").stdout
        (row,) = [line for line in text.splitlines() if line.startswith("output state")]
        outputs = json.loads(hairpipe(f"explain shot.toml sum@{frame} --json").stdout)["outputs"]
        result = hairpipe(f"get shot.toml sum.state@{frame} -o state.npz")
        assert kept == outputs["state"]["kept"] == ("not kept" not in row) == (result.exit_code == 0)
        assert kept or f"output 'state' of 'sum@{frame}' was not kept" in result.stderr
