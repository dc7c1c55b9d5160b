"""Playing gives what a run gives, without a trace, and takes other settings while it goes on."""

import pytest

from hairpipe.engine.run.player import Player, played_nodes, playing_environment
from hairpipe.errors import BadInput

pytestmark = pytest.mark.usefixtures("kept")


def test_playing_equals_the_run_and_repeats(shot):
    shot.run()
    shot.tally()
    graph, before = shot.load(), shot.results()
    player = Player(graph, shot.store, "sum")
    assert [node.name for node in player.nodes] == ["sum"]
    for frame in [*range(1, 11), 1, 2, 3]:
        played = player.advance()
        assert played.frame == frame and played.values["number"].value == shot.value(f"sum@{frame}", "number")
        assert list(played.seconds) == ["sum"]
    assert shot.tally() == {"add_up": 13} and shot.results() == before


def test_missing_inputs_are_refused_and_other_settings_count_from_the_next_frame_on(shot):
    with pytest.raises(BadInput, match="move@1 has not been computed"):
        Player(shot.load(), shot.store, "sum")
    shot.run()
    player = Player(shot.load(), shot.store, "sum")
    with pytest.raises(BadInput, match="move@1 has not been computed"):
        player.take(shot.load(**{"seed.value": 77}))
    assert player.advance().values["number"].value == shot.value("sum@1", "number")
    player.take(shot.load(**{"sum.warn": 2}))
    with pytest.warns(UserWarning, match="a strand is too short"):
        assert player.advance().frame == 2


def test_a_failure_passes_and_the_next_frame_is_the_first(shot):
    shot.run()
    player = Player(shot.load(), shot.store, "sum")
    player.advance()
    function = player.nodes[0].type.function
    object.__setattr__(player.nodes[0].type, "function", lambda **given: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        player.advance()
    object.__setattr__(player.nodes[0].type, "function", function)
    assert player.advance().frame == 1


@pytest.mark.parametrize("node", ["move", "list"])
def test_only_what_follows_a_simulation_is_played(shot, node):
    with pytest.raises(BadInput, match="does not depend on a simulation"):
        played_nodes(shot.load().upto([node]), node)


def test_a_process_that_plays_has_one_thread(shot, monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    assert playing_environment(shot.load(), shot.store)["NUMBA_NUM_THREADS"] == "1"
