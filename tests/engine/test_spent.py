"""A node takes what other nodes took, as their records have it."""

import pytest

from hairpipe.errors import BadInput

from .conftest import CHAIN

BILL = """
[twin]
like = "move"
turn = 999
[bill]
type = "toll"
in.nodes = NODES
"""


def write(shot, nodes):
    shot.write(CHAIN + BILL.replace("NODES", nodes))


def bill(shot, nodes):
    """Run a bill of these nodes, and give what it came to."""
    write(shot, nodes)
    assert not shot.run(to=["bill"]).failures
    return shot.value("bill")


def taken(shot, node):
    """Add up what the records of a node say."""
    keys = [shot.plan()[f"{node}@{frame}"].key for frame in range(1, 11)]
    return sum(shot.store.record(key).processor for key in keys)


def test_spent_times_are_those_of_the_records(shot):
    assert bill(shot, '"sum"') == pytest.approx(taken(shot, "sum")) and taken(shot, "sum") > 0.0
    assert bill(shot, '["sum", "move"]') == pytest.approx(taken(shot, "sum") + taken(shot, "move"))


def test_nodes_that_come_to_the_same_values_are_billed_apart(shot):
    """By content they would share one result, and the dearer of two models would cost what the cheaper does."""
    first, second = bill(shot, '"move"'), bill(shot, '"twin"')
    assert (first, second) == pytest.approx((taken(shot, "move"), taken(shot, "twin"))) and first != second
    assert shot.tally()["toll"] == 2


def test_it_is_cached_as_any_result(shot):
    first = bill(shot, '"sum"')
    shot.tally()
    assert bill(shot, '"sum"') == first and shot.tally() == {}
    assert shot.plan()["bill"].status == "cached"


@pytest.mark.parametrize(
    ("nodes", "reported"),
    [
        ('"seed"', "takes the time of each frame, 'seed' has one value for the shot"),
        ('"sum.state"', "takes the time of a node, 'state' is one of its outputs"),
        ('"summ"', "did you mean 'sum'"),
    ],
)
def test_only_nodes_with_frames_are_billed_as_a_whole(shot, nodes, reported):
    write(shot, nodes)
    with pytest.raises(BadInput, match=reported):
        shot.load()
