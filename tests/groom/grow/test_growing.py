"""Hair grown on a ball: lengths, roots, clearance, curls, paint."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.solid import distance_and_normal, solid_of
from hairpipe.geometry.triangle_tree import project, tree_over
from hairpipe.groom.growing import GAP, RISE, closed, grow, keep_out, lay, lift_off, wind
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Comb, Curl, Style
from hairpipe.values import Body, Mesh
from hairpipe.values.painting import Canvas, Paint, Painted, PaintedDegrees, PaintedMetres
from hairpipe.values.triangles import Sites, site_points, twin_corners

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


def test_it_depends_on_the_seed_and_not_on_the_threads(ball, same_on_threads):
    def compute(seed: int = 0) -> list:
        groom, _ = grown(ball, CURLY, seed=seed)
        return [replace(groom, maps={}), *groom.maps.values()]

    assert not np.array_equal(same_on_threads(compute)[0].points, compute(seed=1)[0].points)


STEP = 0.002


@pytest.fixture(scope="module")
def solid(sphere):
    return solid_of(sphere(0.1, level=5))


def laid(solid, root, ahead, comb=(0.0, 0.0, 0.0), layer=0.005, bend=0.03, count=200):
    axis = np.empty((count, 3))
    axis[0] = root
    lay(solid, axis, tuple(ahead), comb, layer, bend, STEP)
    return axis


def test_hair_from_the_top_slides_down_over_the_head_in_its_layer(solid):
    for layer in (0.002, 0.015):
        axis = laid(solid, (0.0, 0.1, 0.0), np.array([0.8, 0.6, 0.0]), comb=(0.7, 0.0, 0.0), layer=layer, bend=STEP)
        height = np.linalg.norm(axis, axis=1) - 0.1
        way = np.arange(200) * STEP
        beside = (axis[:, 1] > 0) & (way > 0.05)
        assert beside.any() and (height[1:] > 0).all()
        assert np.allclose(height[beside], layer * (1 - np.exp(-way[beside] / RISE)), atol=0.0005)


def test_hair_free_of_the_body_hangs(solid):
    axis = laid(solid, (0.1, 0.0, 0.0), (1.0, 0.0, 0.0))
    tangent = np.diff(axis, axis=0) / STEP
    assert np.allclose(tangent[-1], (0, -1, 0), atol=1e-3)
    assert np.allclose(np.linalg.norm(tangent, axis=1), 1)


def test_it_turns_over_the_bending_length(solid):
    """Free hair that starts level turns by dt/ds = (down - t) / bend across t: a shape that scales with bend."""
    level = [laid(solid, (0.1, 0.0, 0.0), (1.0, 0.0, 0.0), bend=bend)[-1, 0] - 0.1 for bend in (0.01, 0.02, 0.04)]
    assert np.allclose(np.diff(np.log(level)), np.log(2), atol=0.15)


def test_the_comb_pulls_only_what_lies_on_the_body(solid):
    top = laid(solid, (0.0, 0.1, 0.0), (0.0, 0.6, -0.8), comb=(0.0, 0.0, -2.0), count=40)
    assert np.allclose(top[:, 0], 0, atol=0.005) and top[-1, 2] < -0.05
    free = laid(solid, (0.1, 0.0, 0.0), (1.0, 0.0, 0.0), comb=(0.0, 0.0, -1.0))
    assert np.allclose(np.diff(free, axis=0)[-1] / STEP, (0, -1, 0), atol=1e-3)


def test_curves_are_lifted_out_of_the_body_and_no_farther(solid):
    t = np.linspace(0, 1, 101)[:, None]
    curve = (1 - t) * (0.1, 0.0, 0.0) + t * (-0.3, 0.02, 0.0)
    lifted = curve.copy()
    lift_off(solid, lifted, 0.003)
    height = np.linalg.norm(lifted, axis=1) - 0.1
    assert np.array_equal(lifted[0], curve[0])
    way = np.linalg.norm(curve - curve[0], axis=1)
    assert (height > 0.003 * np.minimum(way / RISE, 1) - 2e-4).all()
    clear = np.linalg.norm(curve, axis=1) > 0.1035
    assert clear.any() and np.array_equal(lifted[clear], curve[clear])


@pytest.mark.parametrize("start", [(0.1, 0.0, 0.0), (0.0, 0.3, 0.0)], ids=["from the skin", "from above"])
def test_a_curl_that_runs_through_the_body_is_kept_out_and_keeps_its_lengths(solid, start):
    way = np.linspace(0.0, 0.5, 126)[:, None]
    turn = way / 0.03 * 2.0 * np.pi
    aside = np.cross(start, (0.0, 0.0, 10.0)) * 0.006 / np.linalg.norm(start) / 10.0
    curl = np.array(start) * (1.0 - way / np.linalg.norm(start))
    curl = curl + aside * (np.cos(turn) - 1.0) + np.array((0.0, 0.0, 0.006)) * np.sin(turn)
    kept = curl.copy()
    keep_out(solid, kept, 0.001)
    height = np.linalg.norm(kept, axis=1) - 0.1
    middles = np.linalg.norm(0.5 * (kept[1:] + kept[:-1]), axis=1) - 0.1
    assert np.array_equal(kept[0], curl[0]) and np.linalg.norm(curl, axis=1).min() < 0.01
    assert height[1:].min() > 0.0 and height[20:].min() > 0.0004 and middles.min() > -1e-4
    lengths, before = (np.linalg.norm(np.diff(points, axis=0), axis=1) for points in (kept, curl))
    assert np.allclose(lengths, before, rtol=1e-12)


def test_points_outside_of_the_body_are_unchanged(solid):
    curve = np.array((0.1, 0.0, 0.0)) + np.linspace(0.0, 0.2, 41)[:, None] * (0.8, -0.6, 0.0)
    kept = curve.copy()
    keep_out(solid, kept, 0.001)
    assert np.array_equal(kept, curve)


PIECE, RADIUS, PITCH, ONSET = 0.0005, 0.006, 0.02, 0.03


def wound(axis, phase=0.3):
    curve = axis.copy()
    wind(curve, PIECE, RADIUS, PITCH, ONSET, phase)
    return curve


def straight(direction, count=400):
    return np.arange(count)[:, None] * PIECE * np.asarray(direction) / np.linalg.norm(direction)


def test_on_a_straight_axis_it_is_a_helix_in_closed_form():
    for direction in ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.3, -0.5, 0.8)):
        axis = straight(direction)
        off = wound(axis) - axis
        s = np.arange(400) * PIECE
        settled = s > ONSET
        assert np.allclose(off @ direction, 0, atol=1e-15)
        assert np.allclose(np.linalg.norm(off[settled], axis=1), RADIUS)
        turn = np.arccos(np.clip(np.sum(off[settled][1:] * off[settled][:-1], axis=1) / RADIUS**2, -1, 1))
        assert np.allclose(turn, 2 * np.pi * PIECE / PITCH, atol=1e-6)


def test_it_turns_one_way_by_one_turn_a_pitch():
    axis = straight((0.0, -1.0, 0.0))
    off = wound(axis) - axis
    angle = np.unwrap(np.arctan2(off[1:, 2], off[1:, 0]))
    assert np.isclose(abs(angle[-1] - angle[0]), 2 * np.pi * 398 * PIECE / PITCH)


def test_it_grows_out_of_the_root():
    axis = straight((0.0, -1.0, 0.0))
    radius = np.linalg.norm(wound(axis) - axis, axis=1)
    assert radius[0] == 0 and (np.diff(radius) > -1e-15).all()
    assert np.isclose(radius[30], RADIUS / 2), "half way up the smooth step"


def test_the_phase_turns_it_about_the_axis():
    axis = straight((0.0, -1.0, 0.0))
    off, turned = wound(axis, 0.0) - axis, wound(axis, 1.1) - axis
    cosine = np.sum(off * turned, axis=1)[100:] / RADIUS**2
    assert np.allclose(cosine, np.cos(1.1))


def test_around_a_bent_axis_it_stays_at_its_radius_without_twist():
    angle = np.arange(300) * PIECE / 0.05
    axis = 0.05 * np.stack([np.cos(angle), np.sin(angle), np.zeros(300)], axis=1)
    off = (wound(axis) - axis)[80:-1]
    outward, upward = axis[80:-1] / 0.05, np.array([0.0, 0.0, 1.0])
    assert np.allclose(np.linalg.norm(off, axis=1), RADIUS)
    around = np.unwrap(np.arctan2(off @ upward, np.sum(off * outward, axis=1)))
    assert np.allclose(np.abs(np.diff(around)), 2 * np.pi * PIECE / PITCH, atol=1e-3)


def without(mesh: Mesh, gone: np.ndarray) -> Mesh:
    """The mesh without the triangles that have a vertex among those."""
    return Mesh(mesh.points, mesh.triangles[~gone[mesh.triangles].any(axis=1)])


@pytest.mark.parametrize("flip", [False, True])
def test_points_are_inside_or_outside_of_a_ball_with_holes_as_of_a_whole_one(sphere, flip):
    whole = sphere(0.1, level=3)
    order = np.random.default_rng(0).permutation(len(whole.points)) if flip else np.arange(len(whole.points))
    whole = Mesh(whole.points[order], np.argsort(order).astype(np.int32)[whole.triangles])
    holes = (whole.points[:, 1] < -0.07) | (whole.points[:, 2] > 0.095)
    mesh = closed(without(whole, holes))
    assert (twin_corners(mesh.triangles) >= 0).all()
    solid = solid_of(mesh)
    around = [(0.0, -0.2, 0.0), (0.05, -0.3, 0.0), (0.0, -0.08, 0.09), (0.09, -0.09, 0.0), (0.0, 0.0, 0.12)]
    assert all(distance_and_normal(solid, point, 0)[0] > 0.0 for point in around)
    assert all(distance_and_normal(solid, point, 0)[0] < 0.0 for point in [(0.0, 0.0, 0.0), (0.0, -0.06, 0.0)])


def test_a_whole_body_and_a_sheet_stay_as_they_are(sphere, sheet):
    for mesh in (sphere(0.1, level=2), sheet(4, 4)):
        assert closed(mesh) is mesh
