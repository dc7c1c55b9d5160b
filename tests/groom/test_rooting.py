"""Strands of reconstructions on a ball: turned, cut and pushed out."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.importing import freed, rooted
from hairpipe.values import Mesh
from hairpipe.values.groom import Curves
from hairpipe.values.strand_arrays import offsets_of, take

RADIUS = 0.1


@pytest.fixture(scope="module")
def ball() -> Mesh:
    """A sphere of 48 x 96 faces; the triangles are at most 0.06 mm inside it."""
    up, round_ = np.meshgrid(np.linspace(0, np.pi, 97), np.linspace(0, 2 * np.pi, 193)[:-1], indexing="ij")
    points = RADIUS * np.stack([np.sin(up) * np.cos(round_), np.cos(up), np.sin(up) * np.sin(round_)], axis=-1)
    a = (np.arange(96)[:, None] * 192 + np.arange(192)).ravel()
    b = (np.arange(96)[:, None] * 192 + (np.arange(192) + 1) % 192).ravel()
    triangles = np.concatenate([np.stack([a, b, a + 192], axis=1), np.stack([b, b + 192, a + 192], axis=1)])
    return Mesh(points.reshape(-1, 3), triangles.astype(np.int32))


def made(*strands: np.ndarray) -> Curves:
    offsets = offsets_of(np.array([len(s) for s in strands]))
    count = len(strands)
    ids, held, spare = np.arange(10, 10 + count, dtype=np.int32), np.zeros(count, bool), np.zeros(count, np.int64)
    points = np.concatenate(strands)
    widths = np.arange(len(points), dtype=float)
    return Curves(points, offsets, ids, held, spare, widths=widths, groups=ids.copy())


def radial(*radii: float) -> np.ndarray:
    return np.array(radii)[:, None] * np.array([0.6, 0.8, 0.0])


def test_strands_begin_at_the_end_nearer_to_the_body(ball):
    curves = made(radial(0.1, 0.12, 0.15), radial(0.19, 0.15, 0.1), radial(0.3, 0.4), radial(0.101, 0.103))
    with pytest.warns(UserWarning) as reported:
        found = rooted(ball, curves, 0.02)
    messages = [str(warning.message) for warning in reported]
    assert (
        messages[0].startswith("1 strands are left out, as neither end is within reach = 0.02 m")
        and "12" in messages[0]
    )
    assert messages[1] == "1 of 3 strands are turned: their last point is the root"
    assert np.allclose(np.linalg.norm(found.points, axis=1), [0.1, 0.12, 0.15, 0.1, 0.15, 0.19, 0.101, 0.103])
    assert found.ids.tolist() == [10, 11, 13] == found.groups.tolist()
    assert found.widths.tolist() == [0, 1, 2, 5, 4, 3, 8, 9], "values stay with their points"
    with pytest.raises(BadInput, match="no strand begins or ends at the body"):
        rooted(ball, take(curves, np.array([2])), 0.02)


@pytest.mark.parametrize("inside", ["push", "cut"])
def test_points_inside_are_pushed_out_or_cut(ball, inside):
    buried = radial(0.05, 0.09, 0.11, 0.13)
    dips = radial(0.1, 0.11, 0.097, 0.12)
    lost = radial(0.02, 0.04)
    good = radial(0.1, 0.12)
    with pytest.warns(UserWarning) as reported:
        found = freed(ball, made(buried, dips, lost, good), inside)
    messages = [str(warning.message) for warning in reported]
    assert messages[0] == "1 strands are left out, inside the body: strands 12"
    assert messages[1] == "1 strands are cut where they leave the body, which is their root"
    done = {"push": "are pushed out", "cut": "end the strands"}[inside]
    assert messages[2] == f"1 points of 1 strands are inside the body and {done}"
    radii = [part.round(4).tolist() for part in np.split(np.linalg.norm(found.points, axis=1), found.offsets[1:-1])]
    middle = {"push": [0.1, 0.11, 0.1, 0.12], "cut": [0.1, 0.11]}[inside]
    assert radii == [[0.1, 0.11, 0.13], middle, [0.1, 0.12]]
    assert found.ids.tolist() == [10, 11, 13]
    assert found.points.shape[0] == len(found.widths)


def test_hair_inside_as_a_whole_is_refused(ball):
    with pytest.raises(BadInput, match="all strands are inside the body"):
        freed(ball, made(radial(0.01, 0.05)), "cut")
