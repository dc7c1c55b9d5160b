"""Strands made elsewhere become a groom: adopted, turned, cut and pushed out."""

import warnings

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.importing import adopt, choose_strands, freed, rooted
from hairpipe.groom.resampling import Cut
from hairpipe.groom.sampling import joined_strands
from hairpipe.groom.settings import SHORTEST
from hairpipe.values import Mesh
from hairpipe.values.groom import Curves, strand_lengths
from hairpipe.values.strand_arrays import offsets_of, take
from hairpipe.values.triangles import Sites, site_points


@pytest.fixture
def strands(ball):
    """Twenty wavy strands of 5 to 24 points, rooted a little above the ball."""
    random = np.random.default_rng(0)
    curves = []
    for count in range(5, 25):
        out = random.normal(size=3)
        out /= np.linalg.norm(out)
        steps = np.outer(np.ones(count), out) * 0.01 + random.normal(size=(count, 3)) * 0.002
        curves.append(out * 0.103 + np.concatenate([np.zeros((1, 3)), np.cumsum(steps[1:], axis=0)]))
    return np.concatenate(curves), np.cumsum([0, *map(len, curves)]).astype(np.int32)


def curves_of(points, offsets, **more):
    count = len(offsets) - 1
    known = {"ids": np.arange(count, dtype=np.int32), "held": np.zeros(count, bool), "spare": np.zeros(count, int)}
    return Curves(points, offsets, **{**known, **more})


def adopted(ball, strands, segments=None, count=None, reach=0.01, segment_length=None, shortest=SHORTEST):
    curves = curves_of(*strands)
    return adopt(ball, curves, cut=Cut(segments, segment_length, shortest), strands=count, reach=reach)


def test_every_strand_is_cut_into_equal_segments_from_root_to_tip(ball, strands):
    points, offsets = strands
    groom = adopted(ball, strands, segments=9)
    assert np.array_equal(groom.offsets, np.arange(21) * 10)
    cut = groom.points.reshape(20, 10, 3)
    assert np.allclose(cut[:, 0], points[offsets[:-1]], atol=1e-15)
    assert np.allclose(cut[:, -1], points[offsets[1:] - 1], atol=1e-9)
    lengths = np.linalg.norm(np.diff(cut, axis=1), axis=2)
    assert np.ptp(lengths, axis=1).max() < 1e-10


def test_strands_keep_their_number_of_segments_by_default(ball, strands):
    groom = adopted(ball, strands)
    assert np.array_equal(groom.offsets, strands[1])


def test_roots_stay_where_they_are_and_are_bound_to_the_nearest_skin(ball, strands):
    groom = adopted(ball, strands, segments=9)
    roots, origins = groom.points[groom.offsets[:-1]], groom.root_frames[:, :, 3]
    assert np.allclose(origins, site_points(ball.mesh, Sites(groom.root_triangles, groom.root_barycentrics)))
    assert np.allclose(np.linalg.norm(roots - origins, axis=1), 0.003, atol=3e-4)
    assert {a.dtype for a in (groom.offsets, groom.ids, groom.root_triangles)} == {np.dtype(np.int32)}


def test_thinned_strands_are_spread_over_all_and_keep_their_ids(ball, strands):
    groom, whole = adopted(ball, strands, 4, 6), adopted(ball, strands, 4)
    assert np.array_equal(groom.ids, [0, 3, 6, 10, 13, 16])
    assert np.array_equal(groom.points.reshape(-1, 5, 3), whole.points.reshape(-1, 5, 3)[groom.ids])
    assert np.array_equal(choose_strands(5, 9), np.arange(5))
    assert np.array_equal(choose_strands(5, None), np.arange(5))


def test_invalid_curves_are_named(ball, strands):
    points, offsets = strands
    broken = points.copy()
    broken[offsets[3] + 1, 2] = np.nan
    with pytest.warns(UserWarning, match="1 strands are left out, with points that are not finite: strands 3$"):
        groom = adopted(ball, (broken, offsets))
    assert np.array_equal(groom.ids, np.delete(np.arange(20), 3))
    with pytest.raises(BadInput, match="strands 0, 1, 2, 3, 4 and 15 more have points that are not finite"):
        adopted(ball, (points * np.nan, offsets))
    with pytest.raises(BadInput, match="no strands"):
        adopted(ball, (np.zeros((0, 3)), np.zeros(1, np.int32)))


def test_strands_that_are_too_short_are_omitted_by_name(ball, strands):
    points, offsets = strands[0].copy(), strands[1]
    for s in (2, 7):  # a point, and a stub
        first = points[offsets[s]]
        points[offsets[s] : offsets[s + 1]] = (
            first + np.linspace(0.0, 3e-4 * (s == 7), offsets[s + 1] - offsets[s])[:, None]
        )
    with pytest.warns(UserWarning, match=r"2 strands are left out, shorter than shortest = 0.001 m: strands 2, 7$"):
        groom = adopted(ball, (points, offsets))
    assert np.array_equal(groom.ids, np.delete(np.arange(20), [2, 7]))
    with pytest.warns(UserWarning, match="1 strands are left out"):
        assert 7 in adopted(ball, (points, offsets), shortest=1e-5).ids
    one = np.array([[0, 0.1, 0], [0, 0.2, 0], [0.1, 0, 0]]), np.array([0, 2, 3], np.int32)
    with pytest.warns(UserWarning, match="strands 1$"):
        assert adopted(ball, one).ids.tolist() == [0]
    with pytest.warns(UserWarning), pytest.raises(BadInput, match="all strands are shorter than shortest = 1 m"):
        adopted(ball, strands, shortest=1.0)


def test_strands_with_segments_too_short_have_fewer_of_them(ball, strands):
    with pytest.warns(UserWarning, match=r"5 strands are cut into fewer segments, .*: strands 0, 1, 2, 3, 4$"):
        groom = adopted(ball, strands, segments=90)
    counts, lengths = np.diff(groom.offsets) - 1, strand_lengths(groom.points, groom.offsets)
    assert (counts[5:] == 90).all() and (lengths / counts >= 0.999 * SHORTEST).all()
    assert (counts[:5] >= 0.97 * lengths[:5] / SHORTEST - 1).all(), "no fewer than needed"


def test_segments_may_be_given_by_their_length(ball, strands):
    groom = adopted(ball, strands, segment_length=0.025)
    counts, lengths = np.diff(groom.offsets) - 1, strand_lengths(groom.points, groom.offsets)
    assert (lengths / counts <= 0.025).all() and len(np.unique(counts)) > 5
    assert np.array_equal(counts, np.ceil(strand_lengths(*strands) / 0.025))
    with pytest.raises(BadInput, match=r"segments = 9 and segment_length = 0.025 are both given \(one of the two\)"):
        adopted(ball, strands, segments=9, segment_length=0.025)


def test_roots_out_of_reach_are_refused(ball, strands):
    with pytest.raises(BadInput, match=r"away from the body: strands 0, 1, 2, 3, 4 and 15 more"):
        adopted(ball, strands, reach=0.002)


def test_roots_in_one_place_are_warned_of(ball, strands):
    points, offsets = np.concatenate([strands[0], strands[0][:5]]), np.append(strands[1], strands[1][-1] + 5)
    with pytest.warns(UserWarning, match="1 strands share their root"):
        adopted(ball, (points, offsets.astype(np.int32)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        adopted(ball, strands)


def test_curls_that_are_ironed_out_are_warned_of_with_segments_that_would_do(ball):
    turn = np.linspace(0.0, 20.0 * np.pi, 241)
    helix = np.stack([0.006 * np.cos(turn), 0.103 + 0.01 * turn / (2.0 * np.pi), 0.006 * np.sin(turn)], axis=1)
    strands = np.concatenate([helix, helix + 0.001]), np.array([0, 241, 482], np.int32)
    with pytest.warns(UserWarning, match="2 strands become more than 10% shorter") as reported:
        adopted(ball, strands, segments=12)
    needed = int(str(reported[0].message).split()[-3])
    assert 35 < needed < 50
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        adopted(ball, strands, segments=needed)
        adopted(ball, strands)


def test_strands_keep_their_own_ids_and_are_named_by_them(ball, strands):
    ids = np.arange(20, dtype=np.int32)[::-1] * 10
    groom = adopt(ball, curves_of(*strands, ids=ids), cut=Cut(5), strands=7, reach=0.01)
    assert np.array_equal(groom.ids, ids[choose_strands(20, 7)])
    with pytest.raises(BadInput, match="away from the body: strands 190, 180, 170"):
        adopt(ball, curves_of(*strands, ids=ids), cut=Cut(5), strands=None, reach=0.002)


def test_widths_follow_resampled_strands(ball, strands):
    points, offsets = strands
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    begin, end = way[offsets[:-1]], way[offsets[1:] - 1]
    share = np.concatenate(
        [(way[a:b] - way[a]) / (z - y) for a, b, y, z in zip(offsets[:-1], offsets[1:], begin, end, strict=True)]
    )
    curves = curves_of(*strands, widths=1e-4 * (1.0 - 0.5 * share))
    groom = adopt(ball, curves, cut=Cut(10), strands=None, reach=0.01)
    assert np.allclose(groom.widths.reshape(20, 11), 1e-4 * np.linspace(1.0, 0.5, 11), rtol=1e-9)
    assert np.array_equal(take(groom, np.array([3, 1])).widths, groom.widths.reshape(20, 11)[[3, 1]].ravel())


def test_the_shape_that_grows_from_the_body_is_taken(ball, strands):
    points, offsets = strands
    away = points + np.array((0.0, 0.05, 0.0))
    for shown, rest in ((points, away), (away, points), (away, None)):
        groom = adopt(ball, curves_of(shown, offsets, rest=rest), cut=Cut(), strands=None, reach=0.1)
        wanted = away if rest is None else points
        assert np.array_equal(groom.points[groom.offsets[:-1]], wanted[offsets[:-1]])


def test_curve_is_cut_at_the_skin(ball, strands):
    points, offsets = strands
    spare = np.full(20, 1)
    groom = adopt(ball, curves_of(points, offsets, spare=spare), cut=Cut(), strands=None, reach=0.01)
    assert np.array_equal(groom.offsets, offsets), "roots on the skin are roots"
    inward = points.copy()
    for s in range(20):
        inward[offsets[s]] = 2.0 * points[offsets[s] + 1] - points[offsets[s]]
        inward[offsets[s] + 1] = points[offsets[s]]
    groom = adopt(ball, curves_of(inward, offsets, spare=spare), cut=Cut(), strands=None, reach=0.01)
    assert np.array_equal(groom.points[groom.offsets[:-1]], points[offsets[:-1]])
    assert np.array_equal(np.diff(groom.offsets), np.diff(offsets) - 2)


def test_tips_are_held_where_the_file_or_the_setting_says(ball, strands):
    held = np.arange(20) % 2 == 0
    curves = curves_of(*strands, held=held)

    def bound(tips, reach=0.5):
        return adopt(ball, curves, cut=Cut(4), strands=None, reach=reach, tips=tips)

    groom = bound("file")
    assert np.array_equal(groom.tip_triangles >= 0, held)
    tips, sites = groom.points[groom.offsets[1:] - 1], Sites(np.maximum(groom.tip_triangles, 0), groom.tip_barycentrics)
    assert np.allclose(groom.tip_frames[held, :, 3], site_points(ball.mesh, sites)[held])
    off = np.linalg.norm(tips - groom.tip_frames[:, :, 3], axis=1)
    assert np.allclose(off, np.linalg.norm(tips, axis=1) - 0.1, atol=5e-4)
    assert bound("free").tip_triangles is None and (bound("held").tip_triangles >= 0).all()
    with pytest.warns(
        UserWarning, match=r"10 tips are bound to a place of the body more than reach = 0.01 m away: strands 0, 2,"
    ):
        bound("file", 0.01)
    few = take(groom, np.array([1, 2]))
    assert np.array_equal(few.tip_triangles, groom.tip_triangles[[1, 2]])
    both = joined_strands((bound("free"), groom))
    assert np.array_equal(both.tip_triangles, np.concatenate([np.full(20, -1), groom.tip_triangles]))


RADIUS = 0.1


@pytest.fixture(scope="module")
def globe(sphere) -> Mesh:
    """A sphere; the triangles are at most 0.01 mm inside it."""
    return sphere(RADIUS, level=6)


def made(*strands: np.ndarray) -> Curves:
    offsets = offsets_of(np.array([len(s) for s in strands]))
    count = len(strands)
    ids, held, spare = np.arange(10, 10 + count, dtype=np.int32), np.zeros(count, bool), np.zeros(count, np.int64)
    points = np.concatenate(strands)
    widths = np.arange(len(points), dtype=float)
    return Curves(points, offsets, ids, held, spare, widths=widths, groups=ids.copy())


def radial(*radii: float) -> np.ndarray:
    return np.array(radii)[:, None] * np.array([0.6, 0.8, 0.0])


def test_strands_begin_at_the_end_nearer_to_the_body(globe):
    curves = made(radial(0.1, 0.12, 0.15), radial(0.19, 0.15, 0.1), radial(0.3, 0.4), radial(0.101, 0.103))
    with pytest.warns(UserWarning) as reported:
        found = rooted(globe, curves, 0.02)
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
        rooted(globe, take(curves, np.array([2])), 0.02)


@pytest.mark.parametrize("inside", ["push", "cut"])
def test_points_inside_are_pushed_out_or_cut(globe, inside):
    buried = radial(0.05, 0.09, 0.11, 0.13)
    dips = radial(0.1, 0.11, 0.097, 0.12)
    lost = radial(0.02, 0.04)
    good = radial(0.1, 0.12)
    with pytest.warns(UserWarning) as reported:
        found = freed(globe, made(buried, dips, lost, good), inside)
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


def test_hair_inside_as_a_whole_is_refused(globe):
    with pytest.raises(BadInput, match="all strands are inside the body"):
        freed(globe, made(radial(0.01, 0.05)), "cut")
