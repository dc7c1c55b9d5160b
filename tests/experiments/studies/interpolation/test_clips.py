"""Keys and the frames between them are those that the run has."""

from collections.abc import Sequence

import numpy as np
import pytest

from hairpipe.body.shapes import build_box
from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.interpolation.bodies import parts_of, skin_at
from hairpipe.graphs.experiments.studies.interpolation.cases import CASES
from hairpipe.graphs.experiments.studies.interpolation.clips import Clip, clip_table
from hairpipe.levelset.bake import bake
from hairpipe.values import Table

VOXEL, HALF_WIDTH = 0.1, 4.0
TURN = CASES[2]


@pytest.fixture(scope="module")
def clip():
    """A body that turns by 30 degrees over four steps, at any five frames."""
    skins = [skin_at(TURN, n / 4) for n in range(5)]
    surfaces = [bake(skin, VOXEL, HALF_WIDTH) for skin in skins]
    shapes = [bake(solid.mesh(), VOXEL, HALF_WIDTH) for solid in TURN.solids]
    parts = [parts_of(TURN, shapes, n / 4) for n in range(5)]

    def at(frames: Sequence[int]) -> Clip:
        kinds = [dict(zip(frames, values, strict=True)) for values in (skins, surfaces, parts)]
        return Clip(*(Frames(tuple(frames), kind.__getitem__) for kind in kinds))

    return at


def table_at(clip, frames: Sequence[int], dt: float) -> Table:
    return clip_table(skin_at(TURN, 0.0), clip(frames), 2, dt)


def test_frames_that_are_omitted_are_not_requested(clip):
    full, sparse = table_at(clip, range(1, 6), 1 / 24), table_at(clip, range(1, 11, 2), 1 / 48)
    assert set(full["time [keys]"]) == {0.0, 0.5, 1.0}
    for name in full.names:
        np.testing.assert_array_equal(full[name], sparse[name])


def test_time_between_keys_is_that_of_the_frame(clip):
    assert set(table_at(clip, (1, 2, 5, 8, 9), 1 / 24)["time [keys]"]) == {0.0, 0.25, 0.75, 1.0}


def test_a_body_of_another_rest_is_refused(clip):
    with pytest.raises(BadInput, match=r"in\.body: the triangles are not those of in\.rest"):
        clip_table(build_box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)), clip(range(5)), 2, 1 / 24)
