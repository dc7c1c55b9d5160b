"""`hairpipe warm`: what a graph needs is evaluated, and nothing is left but kernels."""

from collections import Counter
from pathlib import Path

from hairpipe.app.api.shot import shots_to_warm


def test_the_first_two_frames_are_computed_and_nothing_is_kept(shot, hairpipe):
    before = {path for path in shot.parent.rglob("*") if "__pycache__" not in path.parts}
    done = hairpipe("warm shot.toml -j1 -q")
    assert done.exit_code == 0 and done.stdout == ""
    counts = Counter(line.split()[0] for line in Path("tally").read_text().splitlines())
    assert counts == {"make_seed": 1, "move_seed": 2, "add_up": 2, "write_list": 1, "draw_number": 2}
    after = {path for path in shot.parent.rglob("*") if "__pycache__" not in path.parts}
    assert after - before == {Path("tally").absolute()}


def test_a_node_that_fails_is_reported(failing, hairpipe):
    failing.write_text(failing.read_text().replace("frames = [1, 6]", "frames = [3, 6]"))
    done = hairpipe("warm shot.toml -j1")
    assert done.exit_code == 1 and "shot.toml: not all kernels are compiled" in done.stdout
    assert "bad@3" in done.stderr


def test_shipped_shots_are_known():
    assert "demo" in shots_to_warm() and not any("/" in name for name in shots_to_warm())
