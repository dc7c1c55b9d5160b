"""Hair grown on a ball: lengths, roots, clearance, curls, paint."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import project, tree_over
from hairpipe.groom.growing import GAP, RISE, grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Comb, Curl, Style
from hairpipe.values import Body
from hairpipe.values.painting import Canvas, Paint, Painted, PaintedDegrees, PaintedMetres
from hairpipe.values.triangles import Sites, site_points

SEGMENTS = 20
SHORT = Style(length=PaintedMetres(0.08))


def no_image(path: Path) -> np.ndarray:
    raise AssertionError(f"{path} is not asked for")


def grown(body: Body, style: Style = SHORT, strands=200, segments=SEGMENTS, density=None, seed=0):
    groom = grow(Canvas(body, no_image, seed), style, density, strands, Cut(segments))
    return groom, groom.points.reshape(-1, segments + 1, 3)


def strand_lengths(points):
    return np.linalg.norm(np.diff(points, axis=1), axis=2)


CURLY = replace(SHORT, curl=Curl(PaintedMetres(0.004), PaintedMetres(0.02)))


@pytest.mark.parametrize("style", [SHORT, CURLY], ids=["straight", "curly"])
def test_segments_are_equal_and_add_up_to_the_length(ball, style):
    _, points = grown(ball, style)
    assert points.shape == (200, SEGMENTS + 1, 3)
    assert np.allclose(strand_lengths(points), 0.08 / SEGMENTS, rtol=1e-9)


@pytest.mark.parametrize("style", [SHORT, CURLY], ids=["straight", "curly"])
def test_hair_starts_on_the_skin_and_stays_outside_the_body(ball, style):
    groom, points = grown(ball, style)
    assert np.array_equal(points[:, 0], groom.root_frames[:, :, 3])
    sites = Sites(groom.root_triangles, groom.root_barycentrics)
    assert np.allclose(points[:, 0], site_points(ball.mesh, sites), atol=1e-15)
    outside = np.linalg.norm(points[:, 1:], axis=2) > np.linalg.norm(points[:, :1], axis=2) - 1e-4
    _, distance = project(tree_over(ball.mesh.points[ball.mesh.triangles]), points[:, 1:].reshape(-1, 3))
    way = 0.08 / SEGMENTS * np.arange(1, SEGMENTS + 1)
    assert outside.all() and (distance.reshape(200, SEGMENTS) > 0.9 * GAP * np.minimum(way / RISE, 1)).all()


def test_hair_of_metres_is_reported(ball):
    with pytest.warns(UserWarning, match="hair of up to 20 m: is length in metres"):
        grown(ball, replace(SHORT, length=PaintedMetres(20.0)), strands=3)


def test_a_groom_says_what_the_data_type_says(ball):
    groom, _ = grown(ball)
    assert groom.points.dtype == np.float64 and groom.points.flags.c_contiguous
    assert {a.dtype for a in (groom.offsets, groom.ids, groom.root_triangles)} == {np.dtype(np.int32)}
    assert np.array_equal(groom.offsets, np.arange(201) * (SEGMENTS + 1))
    assert len(np.unique(groom.ids)) == 200 and groom.root_frames.shape == (200, 3, 4)
    assert groom.root_uv.dtype == np.float32 and groom.root_uv.shape == (200, 2)
    assert (ball.maps["scalp"][ball.mesh.triangles[groom.root_triangles]].max(axis=1) > 0).all()


def test_hanging_curls_have_the_radius_and_the_pitch_requested(ball):
    radius, pitch = 0.004, 0.02
    long = Style(
        length=PaintedMetres(0.7), curl=Curl(PaintedMetres(radius), PaintedMetres(pitch)), comb=Comb(stray=0.0)
    )
    _, points = grown(ball, long, strands=20, segments=700)
    for hanging in points[:, 400:]:
        x, y, z = hanging.T
        a, b, c = np.linalg.lstsq(np.stack([x, z, np.ones_like(x)], axis=1), x**2 + z**2, rcond=None)[0]
        assert np.isclose(np.sqrt(c + a * a / 4 + b * b / 4), radius, rtol=0.01)
        turned = np.unwrap(np.arctan2(z - b / 2, x - a / 2))
        assert np.isclose(np.ptp(y) / np.abs(turned[-1] - turned[0]) * 2 * np.pi, pitch, rtol=0.01)


def test_hair_leaves_the_skin_at_the_angle_of_lift(ball):
    for lift in (30.0, 80.0):
        style = Style(PaintedMetres(0.002), PaintedDegrees(lift), bend=10.0, volume=0.0)
        groom, points = grown(ball, style, segments=1)
        direction = (points[:, 1] - points[:, 0]) / 0.002
        angle = np.degrees(np.arcsin(np.sum(direction * groom.root_frames[:, :, 2], axis=1)))
        assert np.allclose(angle, lift, atol=0.1)


def test_hair_parts_to_both_sides_and_is_combed_back(ball):
    _, points = grown(ball, Style(PaintedMetres(0.1), comb=Comb(stray=0.0)))
    root, tip = points[:, 0], points[:, -1]
    front = root[:, 2] > 0.02
    assert (np.sign(tip[front, 0]) == np.sign(root[front, 0])).all()
    assert np.mean(np.abs(tip[front, 0]) > np.abs(root[front, 0])) > 0.8
    _, forward = grown(ball, Style(PaintedMetres(0.1), comb=Comb(stray=0.0, back=Painted(-1.0))))
    assert tip[:, 2].mean() < root[:, 2].mean() < forward[:, -1, 2].mean()


def test_length_follows_paint_and_varies_by_chance(ball, body_of):
    height = np.clip(ball.mesh.points[:, 1] / 0.1, 0, 1)
    body = body_of(ball.mesh, scalp=ball.maps["scalp"], tall=height)
    _, points = grown(body, Style(PaintedMetres(0.08, low=0.02, map="tall")))
    above = points[:, 0, 1] > 0.02
    painted = 0.02 + 0.06 * points[above, 0, 1] / 0.1
    assert np.allclose(strand_lengths(points).sum(axis=1)[above], painted, rtol=1e-9)
    _, varied = grown(ball, Style(PaintedMetres(0.08, variation=0.2)))
    lengths = strand_lengths(varied).sum(axis=1)
    assert 0.064 <= lengths.min() < 0.067 and 0.093 < lengths.max() <= 0.096


def test_hair_painted_away_is_omitted_and_the_rest_keeps_its_ids(ball, body_of):
    left = (ball.mesh.points[:, 0] > 0).astype(float)
    body = body_of(ball.mesh, scalp=ball.maps["scalp"], left=left, none=0 * left)
    groom = grow(Canvas(body, no_image, 0), Style(PaintedMetres(0.08, map="left")), None, 200, Cut())
    _, whole = grown(ball)
    assert 80 < len(groom.ids) < 140 and len(groom.offsets) == len(groom.ids) + 1
    assert np.array_equal(groom.points[groom.offsets[:-1]], whole[groom.ids, 0])
    with pytest.raises(BadInput, match=r"shorter than 0\.001 m"):
        grown(body, Style(PaintedMetres(0.08, map="none")))


def test_density_is_the_scalp_times_what_is_painted(ball, body_of):
    thin = np.where(ball.mesh.points[:, 0] > 0, 1.0, 0.25)
    body = body_of(ball.mesh, scalp=ball.maps["scalp"], thin=thin)
    _, points = grown(body, strands=1000, density=Paint(map="thin"))
    assert abs(np.mean(points[:, 0, 0] > 0) - 0.8) < 0.03
    assert points[:, 0, 1].min() > -0.01
    with pytest.raises(BadInput, match="the body has no map 'scalp'"):
        grown(body_of(ball.mesh))


def test_curls_painted_away_are_straight(ball, body_of):
    body = body_of(ball.mesh, scalp=ball.maps["scalp"], none=np.zeros(len(ball.mesh.points)))
    _, straight = grown(ball)
    for curl in (Curl(PaintedMetres(0.004, map="none")), Curl(pitch=PaintedMetres(0.03, map="none"))):
        _, uncurled = grown(body, replace(SHORT, curl=curl))
        assert np.array_equal(uncurled, straight)
    assert not np.allclose(grown(ball, CURLY)[1], straight, atol=1e-3)


def test_too_few_segments_for_a_curl_are_warned_of(ball):
    with pytest.warns(
        UserWarning, match=r"200 curls have fewer than 4 segments per turn .* segments = (\d+) avoids"
    ) as found:
        grown(ball, CURLY, segments=5)
    enough = int(str(found[0].message).split("segments = ")[1].split()[0])
    turn = np.hypot(2 * np.pi * 0.004, 0.02)
    assert enough == np.ceil(4 * 0.08 / turn)


def test_segments_depend_on_length_and_curl_by_default(ball):
    def counts(length, curl=None):
        style = Style(length=PaintedMetres(length), curl=curl)
        groom = grow(Canvas(ball, no_image, 0), style, None, 20, Cut())
        lengths = np.linalg.norm(np.diff(groom.points, axis=0), axis=1)
        assert np.allclose(np.delete(lengths, groom.offsets[1:-1] - 1).sum(), 20 * length)
        return set(np.diff(groom.offsets) - 1)

    assert counts(0.25) == {50} and counts(0.262) == {55} and counts(0.06) == {25} and counts(2.0) == {200}
    assert counts(0.012) == {12}, "none shorter than a millimetre"
    assert counts(0.25, Curl(PaintedMetres(0.004), PaintedMetres(0.008))) == {155}


def test_segments_may_be_given_by_their_length(ball):
    style = Style(length=PaintedMetres(0.08, variation=0.5))
    groom = grow(Canvas(ball, no_image, 0), style, None, 50, Cut(segment_length=0.01))
    lengths = grow(Canvas(ball, no_image, 0), style, None, 50, Cut(1)).points.reshape(50, 2, 3)
    lengths = np.linalg.norm(lengths[:, 1] - lengths[:, 0], axis=1)
    assert np.array_equal(np.diff(groom.offsets) - 1, np.ceil(lengths / 0.01))


def test_too_short_segments_are_named(ball):
    with pytest.warns(UserWarning, match=r"200 strands are cut into fewer segments, .* 0.001 m: strands 0, 1, .* more"):
        groom = grow(Canvas(ball, no_image, 0), Style(length=PaintedMetres(0.008)), None, 200, Cut(20))
    assert (np.diff(groom.offsets) == 9).all()


def test_it_depends_on_the_seed_and_not_on_the_threads(ball, threads):
    threads(1)
    one, _ = grown(ball, CURLY)
    threads(2)
    two, _ = grown(ball, CURLY)
    fields = [{**vars(groom), **groom.maps, "maps": None} for groom in (one, two)]
    assert all(np.array_equal(a, b) for a, b in zip(*(of.values() for of in fields), strict=True))
    assert not np.array_equal(one.points, grown(ball, CURLY, seed=1)[0].points)
