"""Roots follow the body; each cause for which roots lie off a body is told from the others."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import root_frames
from hairpipe.groom.binding import bind_roots, cause_of_misfit, rigid_strands
from hairpipe.groom.importing import adopt
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import SHORTEST
from hairpipe.values import Groom
from hairpipe.values.groom import Curves
from hairpipe.values.strand_arrays import name_strands
from hairpipe.values.triangles import Sites, site_points, unit_normals


@pytest.fixture
def mesh(sphere):
    return sphere(0.1, level=3)


@pytest.fixture
def sites(mesh):
    random = np.random.default_rng(0)
    return Sites(random.integers(0, len(mesh.triangles), 100).astype(np.int32), random.dirichlet([1, 1, 1], 100))


def carried(mesh, points, sites, roots):
    """Roots moved by the product of the posed frame with the inverse of the rest frame."""
    rest, posed = root_frames(mesh.points, mesh.triangles, *sites), root_frames(points, mesh.triangles, *sites)
    local = np.einsum("sji,sj->si", rest[:, :, :3], roots - rest[:, :, 3])
    return np.einsum("sij,sj->si", posed[:, :, :3], local) + posed[:, :, 3]


def test_points_above_the_body_are_bound_below_themselves(mesh, sites):
    above = site_points(mesh, sites) + 0.004 * unit_normals(mesh)[sites.triangles]
    bound = bind_roots(mesh, above, above, 0.005, np.arange(100))
    assert np.array_equal(bound.triangles, sites.triangles)
    assert np.allclose(bound.barycentrics, sites.barycentrics, atol=1e-9)


@pytest.mark.parametrize("kept", [[0], [0, 1], [0, 1, 2]], ids=["vertices", "edges", "faces"])
def test_errors_of_rounding_bind_a_root_to_no_other_triangle(mesh, kept):
    places = mesh.points[mesh.triangles[:, kept]].mean(axis=1)
    before, ids = bind_roots(mesh, places, places, 1.0, np.arange(len(places))), np.arange(len(places))
    for seed in range(3):
        random = np.random.default_rng(seed)
        points, roots = (x + random.uniform(-1e-12, 1e-12, x.shape) for x in (mesh.points, places))
        after = bind_roots(replace(mesh, points=points), roots, roots, 1.0, ids)
        assert np.array_equal(after.triangles, before.triangles)
        assert np.abs(after.barycentrics - before.barycentrics).max() < 1e-9


def test_frames_are_orthonormal_and_right_handed(mesh, sites):
    frames = root_frames(mesh.points, mesh.triangles, *sites)
    axes = frames[:, :, :3]
    assert np.allclose(np.einsum("sji,sjk->sik", axes, axes), np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(axes), 1)
    assert np.allclose(axes[:, :, 2], unit_normals(mesh)[sites.triangles])
    edge = mesh.points[mesh.triangles[sites.triangles, 1]] - mesh.points[mesh.triangles[sites.triangles, 0]]
    assert np.allclose(np.cross(axes[:, :, 0], edge), 0, atol=1e-15)
    assert np.allclose(frames[:, :, 3], site_points(mesh, sites))


def test_roots_follow_a_rigid_motion_rigidly(mesh, sites):
    turn, shift = Rotation.random(random_state=1).as_matrix(), np.array([0.3, -2.0, 0.7])
    frames = root_frames(mesh.points, mesh.triangles, *sites)
    moved = root_frames(mesh.points @ turn.T + shift, mesh.triangles, *sites)
    assert np.allclose(moved[:, :, :3], turn @ frames[:, :, :3], atol=1e-12)
    roots = site_points(mesh, sites) + np.random.default_rng(2).normal(size=(100, 3)) * 0.003
    assert np.allclose(carried(mesh, mesh.points @ turn.T + shift, sites, roots), roots @ turn.T + shift, atol=1e-12)


def test_an_affine_motion_carries_points_on_the_skin_exactly(mesh, sites):
    stretch, shift = np.array([[1.2, 0.3, 0.0], [0.1, 0.7, 0.2], [0.0, -0.4, 1.1]]), np.array([0.0, 1.0, 0.0])
    roots = site_points(mesh, sites)
    assert np.allclose(
        carried(mesh, mesh.points @ stretch.T + shift, sites, roots), roots @ stretch.T + shift, atol=1e-12
    )


def test_frames_of_a_collapsed_triangle_are_finite(mesh, sites):
    assert np.isfinite(root_frames(np.zeros_like(mesh.points), mesh.triangles, *sites)).all()


def test_roots_out_of_reach_are_named(mesh, sites):
    roots = site_points(mesh, sites)
    roots[[4, 17]] *= 1.3
    with pytest.raises(BadInput, match=r"away from the body: strands 104, 117 .*reach = 0.02 m"):
        bind_roots(mesh, roots, roots, 0.02, 100 + np.arange(100))
    assert name_strands(np.arange(8)) == "strands 0, 1, 2, 3, 4 and 3 more"


@pytest.fixture
def loose_groom():
    """Two strands; where their roots are bound does not count here."""
    points = np.cumsum(np.random.default_rng(2).normal(0.0, 0.02, (11, 3)), axis=0)
    unused = np.zeros(2, np.int32), np.zeros((2, 3)), np.zeros((2, 3, 4)), np.zeros((2, 2), np.float32)
    return Groom(points, np.array([0, 5, 11], np.int32), np.arange(2, dtype=np.int32), *unused)


@pytest.fixture
def turning():
    """A turn about an axis, and a way, at a time [s]."""

    def at(seconds):
        c, s = np.cos(0.7 * seconds), np.sin(0.7 * seconds)
        return np.array([[c, 0.0, s, 0.1 * seconds], [0.0, 1.0, 0.0, -0.2], [-s, 0.0, c, 0.3 * seconds**2]])

    return at


def test_lengths_are_kept_and_velocities_are_the_derivative(loose_groom, turning):
    groom, e = loose_groom, 1e-5
    motions = [np.repeat(turning(t)[None], len(groom.ids), axis=0) for t in (1.0 - e, 1.0, 1.0 + e)]
    before, now, after = (rigid_strands(groom, m, (motions[2] - motions[0]) / (2 * e), 8e-5) for m in motions)
    sizes = [np.linalg.norm(np.diff(points, axis=0), axis=1) for points in (now.points, groom.points)]
    inner = np.delete(np.arange(len(groom.points) - 1), groom.offsets[1:-1] - 1)  # not from strand to strand
    np.testing.assert_allclose(sizes[0][inner], sizes[1][inner], rtol=1e-12)
    np.testing.assert_allclose(now.velocities, (after.points - before.points) / (2 * e), atol=1e-6)


REACH, TWICE = 0.01, np.array([0, 0.4, 0.2])
DOWN = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.fixture
def head(ball):
    """A head that is higher than wide, a metre above the origin and before it."""
    return replace(ball.mesh, points=ball.mesh.points * [1.0, 1.4, 1.2] + [0.0, 1.0, 0.3])


@pytest.fixture
def hair(head):
    """Roots on the upper half of the head, and tips 0.1 m above them."""
    corners = head.points[head.triangles]
    upper = corners.mean(axis=1)[corners.mean(axis=1)[:, 1] > 1.0]
    return upper, upper + np.array([0.02, 0.1, 0.03])


WRONG = {
    "tip first": (lambda roots, tips: (tips, roots), "the other ends lie on it"),
    "centimetres": (lambda roots, tips: (100 * roots, 100 * tips), "hair is in units of 1 cm, the body in metres"),
    "metres": (lambda roots, tips: (roots / 100, tips / 100), "the body is in units of 1 cm, hair in metres"),
    "feet": (lambda roots, tips: (roots / 0.3048, tips / 0.3048), "hair is in units of 1 foot, the body in metres"),
    "z up": (lambda roots, tips: (roots @ DOWN, tips @ DOWN), "hair has Z up in place of Y"),
    "z up in inches": (
        lambda roots, tips: (roots @ DOWN / 0.0254, tips @ DOWN / 0.0254),
        "hair is in units of 1 inch, the body in metres, and hair has Z up in place of Y",
    ),
    "moved twice": (lambda roots, tips: (roots + TWICE, tips + TWICE), "displaced by one vector"),
    "moved far": (lambda roots, tips: (roots - [3.0, 2.0, 1.0], tips - [3.0, 2.0, 1.0]), "displaced by one vector"),
}


@pytest.mark.parametrize(("change", "message"), WRONG.values(), ids=WRONG)
def test_causes_are_distinguished(head, hair, change, message):
    cause = cause_of_misfit(head, *change(*hair), REACH)
    assert cause is not None and message in cause.what


def test_no_cause_is_made_up(head, hair):
    turn = Rotation.from_rotvec([0.0, 0.0, 0.9]).as_matrix()
    assert cause_of_misfit(head, *(3.7 * ends @ turn for ends in hair), REACH) is None


def test_different_times_are_reported(ball):
    out = np.eye(3) * 0.5
    points = np.stack([out, 1.1 * out], axis=1).reshape(-1, 3)
    known = np.arange(3, dtype=np.int32), np.zeros(3, bool), np.zeros(3, np.int64)
    curves = Curves(points, np.array([0, 2, 4, 6], np.int32), *known, time=1002.0)
    for body, when in ((ball, "at rest"), (replace(ball, time=1000.0), "at time code 1000")):
        with pytest.raises(BadInput, match=f"body is read {when}, the moving hair at time code 1002"):
            adopt(body, curves, cut=Cut(None, None, SHORTEST), strands=None, reach=REACH)
