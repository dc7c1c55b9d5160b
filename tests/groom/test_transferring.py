"""A groom transferred to another head: the identity, moved and scaled copies, lengths, places, and what is reported."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.formats.pictures import read_image
from hairpipe.geometry.solid import solid_of
from hairpipe.geometry.triangle_tree import nearest_sites
from hairpipe.groom.growing import depths, grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.sampling import joined_strands
from hairpipe.groom.settings import Curl, Style
from hairpipe.groom.transferring import BENT, transferred
from hairpipe.values import Body, Groom
from hairpipe.values.groom import segment_lengths, strand_lengths
from hairpipe.values.painting import Canvas, PaintedMetres
from hairpipe.values.triangles import Sites, site_points

pytestmark = pytest.mark.kernels
ROUNDING = 2e-6
"""What turning strands out of the skin leaves of the required distance [m]."""


def with_uv(body: Body, apart: float = 2.0) -> Body:
    """The body with texture coordinates from above, those of its lower half at another place."""
    corners = body.mesh.points[body.mesh.triangles]
    below = corners[:, :, 1].mean(axis=1) < 0.0
    uv = corners[:, :, [2, 0]] * 4.0 + 0.5
    uv[below, :, 0] = apart - uv[below, :, 0] if apart else uv[below, :, 0]
    return replace(body, mesh=replace(body.mesh, uv=uv.astype(np.float32)))


def moved_body(body: Body, points: np.ndarray) -> Body:
    return replace(body, mesh=replace(body.mesh, points=points))


@pytest.fixture(scope="module")
def head(sphere, body_of) -> Body:
    mesh = sphere(0.1, level=4)
    return with_uv(body_of(mesh, scalp=(mesh.points[:, 1] > 0.01).astype(float)))


@pytest.fixture(scope="module")
def groom(head) -> Groom:
    style = Style(length=PaintedMetres(0.12, variation=0.3), curl=Curl(PaintedMetres(0.004), PaintedMetres(0.03)))
    grown = grow(Canvas(head, read_image, 1), style, None, 120, Cut(segments=24))
    count = len(grown.ids)
    marks = {"groups": np.arange(count, dtype=np.int32) % 2, "group_names": ("even", "odd")}
    marks |= {"guides": np.arange(count) % 5 == 0, "widths": np.linspace(1e-4, 5e-5, len(grown.points))}
    return replace(grown, ids=grown.ids + 100, **marks)


def other_head(head: Body) -> Body:
    """An egg with a bump, of the same triangles."""
    p = head.mesh.points
    bump = 0.012 * np.exp(-np.sum((p - [0.06, 0.08, 0.0]) ** 2, axis=1) / 0.03**2)
    return moved_body(head, (p * [0.9, 1.15, 1.05]) * (1.0 + bump[:, None] / 0.1))


WAYS = ("vertices", "uv", "surface")


@pytest.mark.parametrize("by", WAYS)
def test_a_groom_transferred_to_its_own_head_is_unchanged(head, groom, by):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = transferred(groom, head, head, by, "kept")
    np.testing.assert_allclose(found.points, groom.points, atol=ROUNDING)
    mesh = head.mesh
    before, after = (site_points(mesh, Sites(g.root_triangles, g.root_barycentrics)) for g in (groom, found))
    np.testing.assert_allclose(after, before, atol=1e-7)
    np.testing.assert_allclose(found.root_uv, groom.root_uv, atol=1e-6)


@pytest.mark.parametrize("by", WAYS)
def test_a_groom_on_a_moved_head_of_another_size_is_moved_and_scaled(head, groom, by):
    """Extents align heads along the axes only: without landmarks, the surface is not turned."""
    turn = np.eye(3) if by == "surface" else Rotation.random(random_state=3).as_matrix()
    shift = np.array([0.3, -1.0, 0.2])
    for size, lengths in ((1.0, "kept"), (1.3, "scaled"), (0.7, "scaled")):
        new = moved_body(head, size * head.mesh.points @ turn.T + shift)
        found = transferred(groom, head, new, by, lengths)
        np.testing.assert_allclose(found.points, size * groom.points @ turn.T + shift, atol=ROUNDING)
        np.testing.assert_allclose(found.root_frames[:, :, :3], turn @ groom.root_frames[:, :, :3], atol=1e-6)


def test_landmarks_align_a_turned_head(head, groom):
    turn = Rotation.from_rotvec([0.2, 1.0, -0.4]).as_matrix()
    new = moved_body(head, 1.2 * head.mesh.points @ turn.T + [0.0, 1.0, 0.0])
    pairs = tuple((*head.mesh.points[i], *new.mesh.points[i]) for i in (0, 2, 4, 9))
    found = transferred(groom, head, new, "surface", "scaled", pairs)
    np.testing.assert_allclose(found.points, 1.2 * groom.points @ turn.T + [0.0, 1.0, 0.0], atol=ROUNDING)


@pytest.mark.parametrize("by", WAYS)
def test_on_another_head_roots_lie_on_the_skin_and_no_point_is_inside(head, groom, by):
    new = other_head(head)
    found = transferred(groom, head, new, by, "kept")
    roots = found.points[found.offsets[:-1]]
    assert nearest_sites(new.mesh, roots)[1].max() < 1e-9
    np.testing.assert_allclose(
        site_points(new.mesh, Sites(found.root_triangles, found.root_barycentrics)), roots, atol=1e-12
    )
    assert depths(*solid_of(new.mesh), found.points).min() > -1e-6
    assert np.abs(found.points - groom.points).max() > 0.01


@pytest.mark.parametrize("by", WAYS)
def test_lengths_of_segments_are_kept_and_all_that_strands_carry(head, groom, by):
    found = transferred(groom, head, other_head(head), by, "kept")
    lengths = (segment_lengths(g.points, g.offsets) for g in (found, groom))
    np.testing.assert_allclose(*lengths, rtol=1e-9)
    for name in ("ids", "offsets", "groups", "guides", "widths"):
        np.testing.assert_array_equal(getattr(found, name), getattr(groom, name))
    assert found.group_names == groom.group_names
    np.testing.assert_array_equal(found.maps["scalp"], groom.maps["scalp"])


def test_neighbours_stay_neighbours_along_their_strands(head, groom):
    """A clump: copies of a strand that grow a millimetre apart."""
    near = np.argsort(np.linalg.norm(groom.points[groom.offsets[:-1]] - [0.03, 0.09, 0.02], axis=1))[:1]
    points = groom.points[groom.offsets[near[0]] : groom.offsets[near[0] + 1]]
    starts = points[0] + np.array([[0.0, 0, 0], [1e-3, 0, 0], [0, 0, 1e-3]])
    sites, _ = nearest_sites(head.mesh, starts)
    places = site_points(head.mesh, sites)
    count = len(points)
    clump = Groom(
        points=(points - points[0] + places[:, None]).reshape(-1, 3),
        offsets=(count * np.arange(4)).astype(np.int32),
        ids=np.arange(3, dtype=np.int32),
        root_triangles=sites.triangles,
        root_barycentrics=sites.barycentrics,
        root_frames=np.zeros((3, 3, 4)),
        root_uv=np.zeros((3, 2), np.float32),
    )
    for by in WAYS:
        curves = transferred(clump, head, other_head(head), by, "kept").points.reshape(3, count, 3)
        assert np.linalg.norm(curves - curves[:1], axis=2).max() < 4e-3


@pytest.fixture
def plane(sheet, body_of) -> Body:
    """A square of 0.4 m in the plane z = 0, whose normal is +Z."""
    mesh = sheet(40, 40)
    return body_of(replace(mesh, points=(mesh.points - [0.5, 0.5, 0.0]) * 0.4))


def laid(body: Body, start: tuple, step: tuple, count: int = 20) -> Groom:
    """A strand from the skin at a place on, straight."""
    root = np.array([start])
    sites, _ = nearest_sites(body.mesh, root)
    points = site_points(body.mesh, sites) + np.arange(count + 1)[:, None] * np.array(step)
    ids = np.zeros(1, np.int32)
    frames = np.concatenate([np.eye(3), root.T], axis=1)[None]
    return Groom(points, np.array([0, count + 1], np.int32), ids, *sites, frames, np.zeros((1, 2), np.float32))


def test_a_strand_that_lies_on_the_skin_is_wound_around_a_cylinder(plane):
    """Of radius R: the segment at a distance x from the root along the skin is turned by x / R."""
    radius = 0.1
    x, y, _ = plane.mesh.points.T
    wound = np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius) - radius], axis=1)
    groom = laid(plane, (0.0, 0.0, 0.0), (0.005, 0.0, 0.0))
    groom = replace(groom, points=groom.points + [0.0, 0.0, 1.0] * np.minimum(np.arange(21.0), 1.0)[:, None] * 0.003)
    with pytest.warns(UserWarning, match="the new head has 1 holes"):
        found = transferred(groom, plane, moved_body(plane, wound), "vertices", "kept")
    ways = np.diff(found.points, axis=0)[1:]
    middles = 0.5 * (groom.points[1:-1, 0] + groom.points[2:, 0])
    turned = np.arctan2(-ways[:, 2], ways[:, 0])
    np.testing.assert_allclose(turned, middles / radius, atol=0.02)


def test_hair_far_from_the_skin_turns_with_the_head_on_average(plane):
    """One root of five is on tilted skin: beyond 6 cm from it, all turn by a fifth of its angle."""
    x, y, _ = plane.mesh.points.T
    slope = np.where(np.hypot(x, y) < 0.03, 0.3 * x, 0.0)
    tilted = moved_body(plane, plane.mesh.points + slope[:, None] * [0.0, 0.0, 1.0])
    groom = joined_strands(tuple(laid(plane, (a, a, 0.0), (0.0, 0.0, 0.01)) for a in (0.0, 0.1, -0.1, 0.15, -0.15)))
    found = transferred(groom, plane, tilted, "vertices", "kept")
    ways = np.diff(found.points[:21], axis=0)
    angles = np.degrees(np.arctan2(ways[:, 0], ways[:, 2]))
    assert angles[0] == pytest.approx(-np.degrees(np.arctan(0.3)), abs=0.5)
    np.testing.assert_allclose(angles[8:], angles[0] / 5.0, atol=0.5)


def said_of(groom: Groom, source: Body, target: Body, by: str) -> str:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        transferred(groom, source, target, by, "kept")
    return "\n".join(str(warning.message) for warning in caught)


def test_roots_whose_coordinates_the_new_head_lacks_are_left_out(head, groom):
    uv = head.mesh.uv.copy()
    elsewhere = (uv[:, :, 1] > 0.5).all(axis=1)
    uv[elsewhere] += 10.0
    new = replace(head, mesh=replace(head.mesh, uv=uv))
    gone = np.count_nonzero(elsewhere[groom.root_triangles])
    said = said_of(groom, head, new, "uv")
    why = "as the new head lacks the texture coordinates of their roots"
    assert said.startswith(f"{gone} strands are left out, {why}: strands 1") and gone > 20
    lost = replace(head, mesh=replace(head.mesh, uv=uv * 0.0 + head.mesh.uv + 20.0))
    with pytest.raises(BadInput, match="texture coordinates of all roots are unused"):
        transferred(groom, head, lost, "uv", "kept")


def test_overlapping_coordinates_take_the_place_nearest_to_the_aligned_one(head, groom):
    below = head.mesh.points[head.mesh.triangles][:, :, 1].mean(axis=1) < 0.0
    uv = head.mesh.uv.copy()
    uv[below, :, 0] = 2.0 - uv[below, :, 0]
    both = replace(head, mesh=replace(head.mesh, uv=uv))
    said = said_of(groom, head, both, "uv")
    assert "strands have texture coordinates of several places, of which the nearest is used" in said
    np.testing.assert_allclose(transferred(groom, head, both, "uv", "kept").points, groom.points, atol=ROUNDING)


def test_mirrored_islands_are_counted(head, groom):
    uv = head.mesh.uv.copy()
    uv[:, :, 0] = 1.0 - uv[:, :, 0]
    mirrored = replace(head, mesh=replace(head.mesh, uv=uv))
    assert f"{len(groom.ids)} of {len(groom.ids)} strands have mirrored texture" in said_of(groom, head, mirrored, "uv")


def test_neighbours_torn_apart_are_counted(head, groom):
    """Half of the head is a metre away: neighbours on either side of the gap are none."""
    apart = head.mesh.points + (head.mesh.points[:, :1] > 0.0) * np.array([1.0, 0.0, 0.0])
    said = said_of(groom, head, moved_body(head, apart), "vertices")
    line = next(line for line in said.splitlines() if "as far from their neighbours" in line)
    assert 2 <= int(line.split()[0]) < len(groom.ids) / 3


def test_strands_that_a_new_head_bends_are_counted(plane):
    """A wall in the way of a strand that lay on the skin."""
    wall = np.where(plane.mesh.points[:, :1] > 0.04, [0.0, 0.0, 0.05], 0.0)
    groom = laid(plane, (0.0, 0.0, 0.0), (0.005, 0.0, 0.0005))
    said = said_of(groom, plane, moved_body(plane, plane.mesh.points + wall), "vertices")
    assert f"1 of 1 strands are bent by more than {BENT:g} degrees out of the new head" in said


def test_heads_that_do_not_correspond_are_refused(head, groom, plane):
    with pytest.raises(BadInput, match=r"the heads have other triangles: 2,048 triangles, 1,026 vertices, and 3,200"):
        transferred(groom, head, plane, "vertices", "kept")
    bare = replace(head, mesh=replace(head.mesh, uv=None))
    with pytest.raises(BadInput, match="the target has no texture coordinates"):
        transferred(groom, head, bare, "uv", "kept")
    with pytest.raises(BadInput, match=r'the target has no map "scalp"'):
        transferred(groom, head, replace(head, maps={}), "surface", "kept")
    with pytest.raises(BadInput, match="2 landmarks, or all on a line"):
        transferred(groom, head, head, "surface", "kept", ((0.0,) * 6, (1.0,) * 6))
    with pytest.raises(BadInput, match="grows on another body"):
        transferred(replace(groom, root_triangles=groom.root_triangles + 10_000), head, head, "uv", "kept")


def test_lengths_are_scaled_by_the_ratio_of_the_heads(head, groom):
    new = moved_body(head, 1.5 * head.mesh.points)
    kept, scaled = (transferred(groom, head, new, "vertices", lengths) for lengths in ("kept", "scaled"))
    before = strand_lengths(groom.points, groom.offsets)
    np.testing.assert_allclose(strand_lengths(kept.points, kept.offsets), before, rtol=1e-9)
    np.testing.assert_allclose(strand_lengths(scaled.points, scaled.offsets), 1.5 * before, rtol=1e-9)


def test_held_tips_are_bound_to_the_new_skin(head, groom):
    tips = groom.points[groom.offsets[1:] - 1]
    sites, _ = nearest_sites(head.mesh, tips)
    count = len(groom.ids)
    held = np.arange(count) % 2 == 0
    frames = np.tile(np.eye(3, 4), (count, 1, 1))
    triangles = np.where(held, sites.triangles, -1).astype(np.int32)
    tied = replace(groom, tip_triangles=triangles, tip_barycentrics=sites.barycentrics, tip_frames=frames)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = transferred(tied, head, head, "vertices", "kept")
    np.testing.assert_array_equal(found.tip_triangles >= 0, held)
    places = site_points(head.mesh, Sites(found.tip_triangles, found.tip_barycentrics))[held]
    np.testing.assert_allclose(places, site_points(head.mesh, sites)[held], atol=1e-5)
