"""When a file plays: one rule for all formats, and a warning where its times and those of the shot do not meet."""

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from hairpipe.engine import Time
from hairpipe.engine.node.declare import First
from hairpipe.formats.gltf import find_take
from hairpipe.nodes.load_mesh_cache import load_mesh_cache
from tests.formats.mesh_cache.test_carried_bodies import COUNT, SQUARE, STEP, alembic, gltf, obj, usd

WRITERS = {"obj": obj, "usd": usd, "gltf": gltf, "alembic": alembic}
formats = pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)


def sample_at(file: Path, frame: int, first: int = 1001, **settings: float) -> tuple[float, str]:
    """Return the sample that a frame shows, and the warnings."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        warnings.filterwarnings("ignore", ".*not used")
        mesh = load_mesh_cache(Time(frame, 24.0), (), None, First(first), file=file, **settings)
    return float((mesh.points - SQUARE)[0, 0] / STEP[0]), "\n".join(str(w.message) for w in warned)


@formats
def test_times_that_reach_the_shot_are_kept_and_held_outside(tmp_path, write: Callable):
    file = write(tmp_path, 1001, 24.0)[1]
    for frame, sample in ((1001, 0), (1003, 2), (1005, 4)):
        assert sample_at(file, frame) == (pytest.approx(sample, abs=1e-4), "")
    for frame, sample in ((995, 0), (1010, 4)):
        found, warned = sample_at(file, frame, first=995)
        assert found == pytest.approx(sample, abs=1e-4)
        assert "at the frames 1001 to 1005 of this shot: outside of them it holds still" in warned


@formats
@pytest.mark.parametrize(("begin", "first", "shown"), [(0, 1001, 1001), (1, 991, 1001), (10, 2001, 2001)])
def test_times_before_the_shot_begin_at_its_begin(tmp_path, write: Callable, begin: int, first: int, shown: int):
    """At 1001, also in a shot with handles, or at the first frame of a later shot."""
    file = write(tmp_path, begin, 24.0)[1]
    for k in (0, 3):
        found, warned = sample_at(file, shown + k, first)
        assert found == pytest.approx(k, abs=1e-4)
        own = f"frames {begin} to {begin + COUNT - 1} of this shot: they begin at frame {shown} instead"
        assert own in warned and f"at = {shown} states this" in warned
        assert sample_at(file, shown + k, first, at=shown) == (pytest.approx(k, abs=1e-4), "")


@formats
def test_a_start_shows_that_time_at_the_frame(tmp_path, write: Callable):
    file = write(tmp_path, 3, 24.0)[1]
    assert sample_at(file, 1012, at=1010, start=4.0) == (pytest.approx(3, abs=1e-4), "")
    found, warned = sample_at(file, 1001, at=1001, start=1001.0)  # as the warning has it
    assert found == pytest.approx(4, abs=1e-4) and "at the frames 3 to 7 of this shot" in warned


@pytest.mark.parametrize("write", [usd, alembic])
def test_samples_of_another_rate_are_named_with_the_remedy(tmp_path, write: Callable):
    """A glTF file is read at the frames of the shot, and the numbers of files are frames."""
    file = write(tmp_path, 1001, 25.0)[1]
    _, warned = sample_at(file, 1001, at=1001)
    assert "1/25 s apart" in warned and "1/24 s: frames lie between samples (speed = 0.96" in warned
    for k in range(COUNT):
        assert sample_at(file, 1001 + k, at=1001, speed=0.96) == (pytest.approx(k, abs=1e-4), "")


@pytest.mark.parametrize(
    ("targets", "take"),
    [
        ([[(0, "rotation")], [(1, "weights")]], [0, 1]),  # Blender's armature and shape keys
        ([[(0, "rotation"), (1, "rotation")], [(1, "rotation")]], [0]),  # two clips
        ([[(0, "rotation")], [(1, "weights")], [(0, "rotation")], [(1, "weights")]], [0, 1]),
    ],
)
def test_animations_that_move_other_nodes_are_one_take(targets: list, take: list[int]):
    channels = [[{"target": {"node": node, "path": path}} for node, path in clip] for clip in targets]
    assert find_take([{"channels": clip} for clip in channels]) == take
