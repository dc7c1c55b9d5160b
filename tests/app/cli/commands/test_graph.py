"""`hairpipe graph`: the graph for others to draw."""

import json
import re


def test_graphviz_gets_every_node_and_edge(shot, hairpipe):
    text = hairpipe("graph shot.toml").stdout
    assert text.startswith("digraph {") and text.rstrip().endswith("}")
    edges = ["seed move seed", "move sum number", "sum list numbers", "sum drawing number"]
    assert [" ".join(found) for found in re.findall(r'"(\w+)" -> "(\w+)" \[label="(\w+)"\]', text)] == edges
    assert len(re.findall(r"\[shape=", text)) == 5


def test_mermaid_gets_every_node_and_edge(shot, hairpipe):
    lines = hairpipe("graph shot.toml --format mermaid").stdout.splitlines()
    assert lines[0] == "graph LR"
    assert '  n_sum[["sum<br>add_up"]]' in lines and "  n_sum -->|numbers| n_list" in lines
    assert len(lines) == 1 + 5 + 4


def test_a_document(shot, hairpipe):
    document = json.loads(hairpipe("graph shot.toml --format json --set seed.value=4 --to move").stdout)
    assert list(document["nodes"]) == ["seed", "move"]
    assert document["nodes"]["seed"]["settings"]["value"] == 4.0
    assert document["nodes"]["move"]["in"] == {"seed": {"node": "seed", "output": ""}}


def test_an_unknown_format_is_refused(shot, hairpipe):
    assert hairpipe("graph shot.toml --format svg").exit_code == 2
