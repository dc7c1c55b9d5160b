"""`like`: a node that is another one but for what it states is the node that is written out, and errors are plain."""

import pytest

from hairpipe.engine.file.load import load_graph
from hairpipe.errors import BadInput

HEAD = "schema = 1\nframes = [1, 3]\nfps = 24\n"
SEED = HEAD + '[seed]\ntype = "make_seed"\nvalue = 3\nbent.strength = 2\n'
MOVE = SEED + '[move]\ntype = "move_seed"\nin.seed = "seed"\nstep = 2\nturn = 2\n'
SUM = MOVE + '[sum]\ntype = "add_up"\nin.number = "move"\ncheckpoint = 2\n'
LIST = SUM + '[list]\ntype = "write_list"\nin.numbers = "sum"\npublish = "list.txt"\n'

SAME = {
    "nothing": ('[other]\nlike = "seed"', '[other]\ntype = "make_seed"\nvalue = 3\nbent.strength = 2'),
    "setting": ('[other]\nlike = "seed"\nvalue = 4', '[other]\ntype = "make_seed"\nvalue = 4\nbent.strength = 2'),
    "group": ('[other]\nlike = "seed"\nbent.strength = 4', '[other]\ntype = "make_seed"\nvalue = 3\nbent.strength = 4'),
    "no group": ('[other]\nlike = "seed"\nwithout = ["bent"]', '[other]\ntype = "make_seed"\nvalue = 3'),
    "no setting": ('[other]\nlike = "seed"\nwithout = ["value"]', '[other]\ntype = "make_seed"\nbent.strength = 2'),
    "group left out": (
        '[base]\nlike = "seed"\nbent = false\n[other]\nlike = "base"\nbent.strength = 4',
        '[base]\nlike = "seed"\n[other]\ntype = "make_seed"\nvalue = 3\nbent.strength = 4',
    ),
    "in a group": (
        '[other]\nlike = "seed"\nwithout = ["bent.strength"]',
        '[other]\ntype = "make_seed"\nvalue = 3\nbent = {}',
    ),
    "edge": (
        '[base]\nlike = "seed"\n[other]\nlike = "move"\nin.seed = "base"\nturn = 3',
        '[base]\nlike = "seed"\n[other]\ntype = "move_seed"\nin.seed = "base"\nstep = 2\nturn = 3',
    ),
    "chain, backwards": (
        '[other]\nlike = "first"\nstep = 5\n[first]\nlike = "move"\nturn = 3',
        '[other]\ntype = "move_seed"\nin.seed = "seed"\nstep = 5\nturn = 3\n[first]\nlike = "move"\nturn = 3',
    ),
    "another type": (
        '[other]\nlike = "move"\ntype = "soften"\nin = { number = "move" }\nwithout = ["in", "step", "turn"]',
        '[other]\ntype = "soften"\nin.number = "move"',
    ),
}
DEEP = "bent" + ".a" * 3000
BAD = {
    "unknown": ('[other]\nlike = "moev"\n', ":21: [other]: like: no node 'moev'", "did you mean 'move'?"),
    "itself": ('[other]\nlike = "other"\n', ":21: [other]: circular `like`: other -> other", "without `like`"),
    "circle": ('[a]\nlike = "b"\n[b]\nlike = "c"\n[c]\nlike = "a"\n', "circular `like`: ", "without `like`"),
    "number": ("[other]\nlike = 3\n", ":21: [other]: like = 3 is not the name", 'like = "node"'),
    "nothing to leave out": (
        '[other]\nlike = "seed"\nwithout = ["bnet"]\n',
        ":22: [other]: without: 'seed' has no 'bnet'",
        "did you mean 'bent'?",
    ),
    "without publish": ('[other]\nlike = "list"\nwithout = ["publish"]\n', "'list' has no 'publish'", "known: "),
    "without text": ('[other]\nlike = "seed"\nwithout = "bent"\n', ":22: [other]: without = 'bent'", "a list of names"),
    "deep": (
        f'[deep]\ntype = "make_seed"\n{DEEP} = 1\n[other]\nlike = "deep"\n{DEEP} = 2\n',
        "a key of more than 16 names",
        "",
    ),
    "without deep": (
        f'[deep]\ntype = "make_seed"\n{DEEP} = 1\n[other]\nlike = "deep"\nwithout = ["{DEEP}"]\n',
        "a key of more than 16 names",
        "",
    ),
    "without like": ('[other]\ntype = "make_seed"\nwithout = []\n', ":22: [other]: without", 'like = "node"'),
    "setting": ('[other]\nlike = "seed"\nvaleu = 3\n', ":22: [other] make_seed: unknown setting 'valeu'", "'value'?"),
    "base": (
        '[other]\nlike = "more"\n[more]\nlike = "seed"\nvaleu = 3\n',
        ":24: [more] make_seed: unknown",
        "'value'?",
    ),
    "not of this type": ('[other]\nlike = "seed"\ntype = "move_seed"\n', "[other] move_seed: unknown setting", ""),
}


@pytest.mark.parametrize("name", SAME)
def test_it_is_the_node_that_is_written_out(shot, name):
    found = []
    for text in SAME[name]:
        shot.write(MOVE + text + "\n")
        node = shot.load().nodes["other"]
        found.append((node.type.name, node.edges, node.settings))
    assert found[0] == found[1]


def test_only_the_changes_of_a_variant_are_computed(shot):
    shot.write(SUM)
    shot.run()
    shot.tally()
    shot.write(SUM + '[slow]\nlike = "move"\nstep = 1\n[other]\nlike = "sum"\nin.number = "slow"\n')
    plan = shot.plan()
    assert {plan[f"{node}@{frame}"].status for node in ("move", "sum") for frame in (1, 2, 3)} == {"cached"}
    assert shot.run().exit_code == 0
    assert shot.tally() == {"move_seed": 3, "add_up": 3}


def test_publish_and_checkpoint_are_not_inherited(shot):
    shot.write(LIST + '[other]\nlike = "list"\n[again]\nlike = "sum"\n')
    nodes = shot.load().nodes
    assert nodes["other"].publish is None and nodes["again"].checkpoint == 24
    assert nodes["other"].edges == nodes["list"].edges and nodes["again"].edges == nodes["sum"].edges


def test_settings_of_a_prototype_apply_to_its_copies(shot):
    shot.write(MOVE + '[other]\nlike = "seed"\nbent.strength = 7\n')
    nodes = shot.load(seed__value=9, seed__bent__strength=1).nodes
    assert nodes["other"].settings == {"value": 9.0, "file": None, "bent": {"strength": 7.0}}


def test_a_group_continues_from_a_plain_value_and_a_plain_value_replaces_it(shot):
    (shot.nodes / "mixed.py").write_text(MIXED)
    text = HEAD + '[a]\ntype = "mixed"\nhow = "fast"\n[b]\nlike = "a"\nhow.often = 3\n[c]\nlike = "b"\nhow = "slow"\n'
    shot.write(text)
    nodes = shot.load().nodes
    assert nodes["b"].settings["how"] == {"value": "fast", "often": 3}
    assert nodes["c"].settings["how"] == {"value": "slow", "often": 1}


MIXED = '''"""A setting that is a value or a group."""
from dataclasses import dataclass
from numeral import Numeral
from tally import numeral
from hairpipe.engine import node

@dataclass(frozen=True)
class How:
    """How it is done.

    value  in which way
    often  and how often
    """

    value: str = "slow"
    often: int = 1

@node(frames="once")
def mixed(*, how: How = How()) -> Numeral:
    """Give a number.

    how  it is done
    """
    return numeral(float(how.often))
'''


@pytest.mark.parametrize("name", BAD)
def test_faults_are_reported_with_their_place(shot, name):
    text, reported, right = BAD[name]
    shot.path.write_text(LIST.replace("checkpoint = 2\n", "") + text)
    with pytest.raises(BadInput) as caught:
        load_graph(shot.path)
    message = str(caught.value)
    assert message.startswith(str(shot.path)) and reported in message and right in message, message
