"""Pictures of strands over time: which frames, which strands, what lies above what, and the same bytes every time."""

import numpy as np
import pytest
from PIL import Image

from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.poses import Panel, Pose, draw_poses, grid_for, panels_of, pieces_of
from hairpipe.graphs.experiments.nodes.plot_strand import plot_strand
from hairpipe.values import Strands

FPS = 25.0
FRAMES = range(1001, 1012)


def strands(frame: int) -> Strands:
    down = np.linspace([0, 0, 0], [0.01 * (frame - 1001), -0.1, 0.02], 8)
    points = np.concatenate([down, down + np.array([0.0, 0.0, 0.05])]).astype(np.float32)
    return Strands(points, np.zeros_like(points), np.array([0, 8, 16], np.int32), 80e-6)


SHOT = Frames(tuple(FRAMES), strands)


def times(**changes) -> list[float]:
    chosen = {"count": 3, "moments": (), "strands": (), "cases": ()} | changes
    (panel,) = panels_of([SHOT], FPS, **chosen)
    return [round(pose.time * FPS) for pose in panel.poses]


def test_frames_are_spread_evenly_or_named():
    assert times() == [0, 5, 10] and times(count=1) == [0] and times(count=99) == list(range(11))
    assert times(moments=(1003, 1007, 2000)) == [2, 6]
    assert times(moments=(7,)) == [0, 5, 10], "a run of other frames shows those"


def test_strands_are_all_or_those_named():
    (panel,) = panels_of([SHOT], FPS, 2, (), (1,), ("one",))
    assert panel.name == "one" and len(panel.poses[1].strands) == 1
    np.testing.assert_allclose(panel.poses[1].strands[0], strands(1011).points[8:], rtol=1e-7)
    for strand in (2, -1):
        with pytest.raises(BadInput, match="from 0 to 1"):
            panels_of([SHOT], FPS, 2, (), (strand,), ())
    with pytest.raises(BadInput, match="2 names for 1"):
        panels_of([SHOT], FPS, 2, (), (), ("one", "two"))


def test_pieces_are_the_segments_with_a_bit_of_their_neighbours():
    points = np.cumsum(np.random.default_rng(2).normal(size=(6, 3)), axis=0)
    pieces = pieces_of(points)
    np.testing.assert_array_equal(pieces[:, 1], points[:-1])
    np.testing.assert_array_equal(pieces[:, 2], points[1:])
    np.testing.assert_array_equal(pieces[[0, -1], [0, 3]], points[[0, -1]])
    on = (pieces[1:, 0] - points[1:-1]) / (points[:-2] - points[1:-1])
    assert np.ptp(on) < 1e-9 and 0 < on.min() < 0.5


def test_the_strand_in_front_hides_the_one_behind(tmp_path):
    """A cross of two strands: its middle has the colour of the pose's strand; the rim cuts the one behind."""
    across, upright = np.linspace([-1, 0, 0], [1, 0, 0], 5), np.linspace([0, -1, 0.0], [0, 1, 0.0], 5)
    images = []
    for depth in (-0.1, 0.1):
        draw_poses(
            tmp_path / "a.png",
            [Panel("", [Pose(0.0, [across, upright + np.array([0, 0, depth])])])],
            "xy",
            size=(600, 600),
        )
        with Image.open(tmp_path / "a.png") as image:
            images.append(np.asarray(image.convert("L")).astype(int))
    differs = np.argwhere(images[0] != images[1])
    assert 4 < len(differs) < 400, "only the crossing differs"
    assert np.ptp(differs, axis=0).max() < 30


@pytest.mark.parametrize("apart", [(0.0, 0.0), (0.0, -0.02), (0.02, 0.0)])
def test_the_node_draws_the_same_bytes(tmp_path, apart):
    def draw() -> bytes:
        return plot_strand(
            (SHOT, SHOT), Time(1001, FPS), Workspace(tmp_path), apart=apart, width=500, height=300
        ).path.read_bytes()

    assert draw() == draw()
    with Image.open(tmp_path / "poses.png") as image:
        assert image.size == (500, 300) and len(image.convert("RGB").getcolors(100_000) or ()) > 50


def test_panels_stand_so_that_they_are_large():
    wide, high = np.array([1.0, 0.1]), np.array([0.1, 1.0])
    assert grid_for(3, wide, (1000, 1000)) == (3, 1) and grid_for(3, high, (1000, 1000)) == (1, 3)
    assert grid_for(4, np.array([1.0, 1.0]), (1000, 1000)) == (2, 2)
    assert grid_for(1, np.array([1.0, 0.0]), (1000, 1000)) == (1, 1)


def test_panels_may_be_fewer_than_places(tmp_path):
    panels = [Panel(name, [Pose(0.0, [np.eye(3)])]) for name in "abc"]
    draw_poses(tmp_path / "a.png", panels, "xy", apart=(0.1, 0.0), size=(600, 600))
    assert (tmp_path / "a.png").stat().st_size > 1000
