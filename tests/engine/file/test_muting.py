"""`mute`: a muted node is not computed, and an edge from it begins where its first input of the same type does."""

import pytest

from hairpipe.errors import BadInput

MUTED = "mute = true\n"


def chain(seed="", soft="", more="", source="seed"):
    """Write a chain of four nodes: further lines of three of them, and the source of the second."""
    return f"""schema = 1
frames = [1, 3]
fps = 24
[seed]
type = "make_seed"
{seed}[soft]
type = "soften"
in.number = "{source}"
{soft}[more]
type = "soften"
in.number = "soft"
{more}[sum]
type = "add_up"
in.number = "more"
"""


BAD = {
    "not a flag": (chain(soft="mute = 1\n"), r"\[soft\]: mute of 'soft' \(true or false\)"),
    "required input": (chain(seed=MUTED), r"\[soft\] soften: socket 'number' is not connected"),
    "circle": (chain(soft=MUTED, more=MUTED, source="more"), r"\[sum\] add_up: in\.number: no node 'more'"),
}


def edges_of(shot, **settings):
    """Load the shot; the source of every input that is connected."""
    nodes = shot.load(**settings).nodes
    return {name: {plug: edge.node for plug, edge in node.edges.items()} for name, node in nodes.items()}


def test_edges_pass_muted_nodes_by(shot):
    expected = {"seed": {}, "sum": {"number": "seed"}}
    shot.write(chain())
    assert edges_of(shot, soft__mute="true", more__mute="true") == expected
    shot.write(chain(soft=MUTED, more=MUTED))
    assert edges_of(shot) == expected
    assert shot.run().exit_code == 0 and shot.tally() == {"make_seed": 1, "add_up": 3}


def test_an_optional_input_is_not_connected_to_a_muted_node_without_inputs(shot):
    shot.write(chain(more='in.other = "third"\n') + '[third]\nlike = "seed"\nmute = true\n')
    assert edges_of(shot)["more"] == {"number": "soft"}


@pytest.mark.parametrize("name", BAD)
def test_invalid_muting_is_reported(shot, name):
    text, message = BAD[name]
    shot.write(text)
    with pytest.raises(BadInput, match=message):
        shot.load()
