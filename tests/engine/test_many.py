"""Sockets that take a list of edges: values come in its order, and every edge counts by itself."""

from collections import Counter

import pytest

from hairpipe.errors import BadInput

HEAD = "schema = 1\nframes = [1, 3]\nfps = 24\n"
SEEDS = HEAD + "".join(f'[s{n}]\ntype = "make_seed"\nvalue = {n}\n' for n in range(1, 12))
GATHER = SEEDS + '[all]\ntype = "gather"\nin.numbers = {}\n'


def test_values_come_in_the_order_of_the_list(shot):
    many = ", ".join(f'"s{n}"' for n in [*range(2, 10), 1, 1, 2])
    lists = {'["s1", "s3", "s2"]': 132, '["s3", "s3"]': 33, '["s2"]': 2, '"s2"': 2, f"[{many}]": 23456789112}
    for listed, expected in lists.items():
        shot.write(GATHER.format(listed))
        shot.run()
        assert shot.value("all") == expected
    assert shot.tally() == Counter(make_seed=11, gather=4), "one edge is the same in a list or alone"


def test_frames_of_several_nodes(shot):
    moves = "".join(f'[m{n}]\ntype = "move_seed"\nin.seed = "s{n}"\n' for n in (1, 2))
    shot.write(GATHER.format('["s1"]\nin.shots = ["m1", "m2"]') + moves)
    shot.run()
    moved = sum(shot.value(f"m{n}@{frame}") for n in (1, 2) for frame in (1, 2, 3))
    assert shot.value("all") == 1 + moved
    assert shot.tally()["gather"] == 1


def test_a_plan_reports_which_edge_changed(shot):
    shot.write(GATHER.format('["s1", "s2"]'))
    shot.run()
    shot.run(s2__value=7, to=["s2"])
    assert shot.plan(s2__value=7)["all"].reason == "input numbers.1"
    shot.write(GATHER.format('["s1", "s2", "s3"]'))
    assert shot.plan()["all"].reason == "input numbers.2 connected"
    shot.write(GATHER.format('["s1"]'))
    assert shot.plan()["all"].reason == "input numbers.1 disconnected"


def test_edges_are_known_by_their_place(shot):
    shot.write(GATHER.format('["s1", "s3"]'))
    graph = shot.load()
    assert [(plug, edge.node) for _, plug, edge in graph.consumers()] == [("numbers.0", "s1"), ("numbers.1", "s3")]
    assert set(graph.upto(["all"]).nodes) == {"s1", "s3", "all"}


@pytest.mark.parametrize(
    ("listed", "reported", "right"),
    [
        ("[]", ":39: [all] gather: in.numbers = []", "or a list of those"),
        ('"s1"\n[none]\ntype = "gather"', "[none] gather: socket 'numbers' is not connected", ""),
        ('["s1", 2]', "in.numbers = ['s1', 2]", "or a list of those"),
        ('[["s1"]]', "in.numbers = [['s1']]", "or a list of those"),
        ('["s1", "s99"]', ":39: [all] gather: in.numbers.1: no node 's99'", "did you mean 's9'?"),
        ('["s1", "s2.x"]', "in.numbers.1: 's2' has no output 'x'", ""),
        ('["all"]', "a cycle: all -> all", ""),
        ('["s1"]\n[m]\ntype = "move_seed"\nin.seed = ["s1"]', "in.seed = ['s1']", '"node" or "node.output", one edge)'),
        ('["m"]\n[m]\ntype = "move_seed"\nin.seed = "s1"', "in.numbers.0: 'm' gives a value per frame", "Frames["),
    ],
)
def test_faults_are_reported_with_their_place(shot, listed, reported, right):
    shot.write(GATHER.format(listed))
    with pytest.raises(BadInput) as caught:
        shot.load()
    assert reported in str(caught.value) and right in str(caught.value), caught.value
