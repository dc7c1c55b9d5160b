"""`hairpipe nodes`: the node types and what they take and give."""

import json


def test_all_are_listed_with_what_they_do(hairpipe):
    lines = hairpipe("nodes").stdout.splitlines()
    assert any(line.startswith("make_bust  ") and "mannequin" in line for line in lines)


def test_one_is_described(shot, hairpipe):
    text = hairpipe("nodes --graph shot.toml move_seed").stdout
    assert text.startswith("move_seed: one value per frame\nMove a number along;")
    assert "inputs\n  seed  Numeral\n" in text and "outputs\n  Numeral\n" in text
    assert "  step   a number in m, >= 0, default 1.0\n" in text
    text = hairpipe("nodes --graph shot.toml gather").stdout
    assert "numbers  Numeral, any number\n" in text
    assert "shots    Numeral, any number, all frames, optional\n" in text
    text = hairpipe("nodes --graph shot.toml make_seed").stdout
    assert "bent           a group, absent by default\n  bent.strength  a number, default 1.0\n" in text
    assert "file           a file, absent by default\n" in text


def test_a_group_shows_the_defaults_it_has_here(hairpipe):
    text = hairpipe("nodes grow_groom").stdout
    style = json.loads(hairpipe("nodes grow_groom --json").stdout)["settings"]
    length = next(field for field in style if field["name"] == "length")
    value = next(field for field in length["group"] if field["name"] == "value")
    assert f"length.value             a number in m, > 0, default {value['default']}" in text
    assert value["unit"] == "m" and value["default"] > 0


def test_a_document_of_all_says_what_cannot_be_loaded(shot, hairpipe):
    document = json.loads(hairpipe("nodes --graph shot.toml --json").stdout)
    found = {node["name"]: node for node in document["nodes"]}
    assert found["soften"]["sockets"][0] == {"name": "number", "type": "Numeral", "view": "pair"} | dict(
        optional=False, many=False
    )
    assert found["soften"]["sockets"][1]["optional"] and found["gather"]["sockets"][0]["many"]
    assert "declares no node" in found["numeral"]["fault"]


def test_an_unknown_type_is_refused_with_the_nearest(hairpipe):
    result = hairpipe("nodes mak_bust")
    assert result.exit_code == 2
    assert result.stderr == "hairpipe: no node type 'mak_bust' (did you mean 'make_bust'?)\n"


def test_types_of_the_experiments_are_listed_on_request(hairpipe):
    usual, everything, of_graph = (
        {line.split()[0] for line in hairpipe(f"nodes{more}").stdout.splitlines()}
        for more in ("", " --all", " --graph experiments/tuft")
    )
    assert "simulate_hair" in usual and "measure_writhe" not in usual
    assert everything == of_graph > usual
    assert hairpipe("nodes measure_writhe").stdout.startswith("measure_writhe: ")
