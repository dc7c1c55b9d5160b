"""One sees where hair will grow before it does."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.engine import Workspace
from hairpipe.errors import BadInput
from hairpipe.nodes.make_bust import make_bust
from hairpipe.nodes.preview_scalp import preview_scalp
from hairpipe.values import Body


@pytest.fixture(scope="module")
def bust() -> Body:
    return make_bust()


@pytest.mark.kernels
def test_the_scalp_is_shown_from_three_sides_and_the_face_is_not_painted(bust: Body, tmp_path: Path) -> None:
    with Image.open(preview_scalp(bust, Workspace(tmp_path), width=120, height=160).path) as image:
        picture = np.asarray(image).astype(float)
    assert picture.shape == (160, 3 * 120 + 8, 3)
    red = picture[..., 0] - picture[..., 2] > 60
    front, side, back = (red[:, place : place + 120] for place in (0, 124, 248))
    assert 100 < front.sum() < side.sum() and front.sum() < back.sum(), "there is more of it behind than before"
    rows = np.flatnonzero(front.any(axis=1))
    assert rows.max() < 90 and np.flatnonzero(back.any(axis=1)).max() > rows.max() + 5


def test_missing_map_is_reported(bust: Body, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"map: the body has no map 'beard' \(its maps: 'length', 'scalp'\)"):
        preview_scalp(bust, Workspace(tmp_path), map="beard")
