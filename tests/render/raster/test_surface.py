"""What a camera sees of a body: triangles and a sphere, whose outline, distance and normals are known."""

import numpy as np
import pytest

from hairpipe.render.camera import Camera
from hairpipe.render.surface import UNSEEN, first_centre, look_at_body, rasterise, see_body, seen_vertices
from hairpipe.values import Mesh

CENTRE, RADIUS, DISTANCE = np.array([0.0, 1.6, 0.0]), 0.09, 0.5


@pytest.fixture(scope="module")
def camera() -> Camera:
    """Half a metre before the sphere."""
    return Camera.look_at(CENTRE + np.array([0.3, 0.0, 0.4]), CENTRE, 40.0, 240, 180)


def test_silhouette_is_the_cone_that_touches_the_sphere(head: Mesh, camera: Camera) -> None:
    surface = see_body(head, camera)
    on_film = camera.focal * RADIUS / np.sqrt(DISTANCE**2 - RADIUS**2)
    assert len(surface.rows) == pytest.approx(np.pi * on_film**2, rel=0.01)
    away = np.hypot(surface.columns + 0.5 - 120, surface.rows + 0.5 - 90)
    assert away.max() <= on_film and away.max() > on_film - 2.0


def test_points_lie_on_the_sphere_and_normals_are_radial(head: Mesh, camera: Camera) -> None:
    surface = see_body(head, camera)
    outward = surface.points - CENTRE
    assert np.linalg.norm(outward, axis=1) == pytest.approx(RADIUS, rel=0.003)
    assert surface.normals == pytest.approx(outward / RADIUS, abs=0.03)


def test_points_fall_back_on_their_pixels(head: Mesh, camera: Camera) -> None:
    surface = see_body(head, camera)
    column, row, depth = camera.project(surface.points).T
    assert column == pytest.approx(surface.columns + 0.5) and row == pytest.approx(surface.rows + 0.5)
    assert depth == pytest.approx(surface.depth[surface.rows, surface.columns])
    assert np.isinf(surface.depth).sum() == surface.depth.size - len(surface.rows)


def test_inside_out_looks_the_same(head: Mesh, camera: Camera) -> None:
    turned = see_body(Mesh(head.points, head.triangles[:, ::-1].copy()), camera)
    assert turned.normals == pytest.approx(see_body(head, camera).normals)


def test_no_normal_near_the_outline_of_a_coarse_body_is_turned_inside(coarse_head: Mesh, camera: Camera) -> None:
    for way in (1, -1):
        surface = see_body(Mesh(coarse_head.points, coarse_head.triangles[:, ::way].copy()), camera)
        outward = (surface.points - CENTRE) / np.linalg.norm(surface.points - CENTRE, axis=1, keepdims=True)
        assert np.einsum("ni,ni->n", surface.normals, outward).min() > 0.9


def test_a_body_around_the_eye_is_not_drawn_wildly(camera: Camera) -> None:
    behind = Mesh(camera.eye + np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, -1]]), np.array([[0, 1, 2]], np.int32))
    assert len(see_body(behind, camera).rows) == 0


def test_vertices_that_are_seen_lie_before_the_horizon(head: Mesh, camera: Camera) -> None:
    outward = (head.points - CENTRE) / RADIUS
    height = outward @ (camera.eye - CENTRE) - RADIUS  # above the plane that touches the sphere there [m]
    seen = np.isin(np.arange(len(head.points)), seen_vertices(look_at_body(head, camera), head.triangles))
    wide = np.abs(outward[:, 1]) < 0.7  # at the poles, and near the horizon, triangles are smaller than pixels
    assert seen[wide & (height > 0.2)].all() and not seen[height < -0.05].any()


def test_a_pixel_sees_a_triangle_when_its_centre_lies_in_it() -> None:
    rng = np.random.default_rng(5)
    for film in rng.uniform(-5, 25, size=(40, 3, 2)):
        seen, _ = rasterise(film, np.array([[0, 1, 2]], np.int32), np.ones(3), 20, 20)
        rows, columns = np.mgrid[0.5:20, 0.5:20]
        centres = np.stack([columns, rows], axis=2)
        sides = [np.cross(film[k - 2] - film[k], centres - film[k]) for k in range(3)]
        inside = (np.min(sides, axis=0) >= 0) | (np.max(sides, axis=0) <= 0)
        assert np.array_equal(seen != UNSEEN, inside)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_closer_triangle_is_seen_in_any_order(order: list[int]) -> None:
    film = np.array([[-9.0, -9], [40, -9], [-9, 40]] * 2)
    closeness = np.array([1.0, 1, 1, 2, 2, 2])
    triangles = np.array([[0, 1, 2], [3, 4, 5]], np.int32)[order]
    seen, close = rasterise(film, triangles, closeness, 8, 8)
    assert (triangles[seen] == [3, 4, 5]).all()
    assert close == pytest.approx(2.0)


def test_triangles_behind_the_eye_are_omitted() -> None:
    film = np.array([[-9.0, -9], [40, -9], [-9, 40]])
    seen, _ = rasterise(film, np.array([[0, 1, 2]], np.int32), np.array([1.0, 0.0, 1.0]), 8, 8)
    assert (seen == UNSEEN).all()


@pytest.mark.parametrize("x", [-1e300, -0.1, 0.0, 0.5, 0.51, 3.5, 7.49, 7.51, 1e300])
def test_first_centre_is_the_first_that_is_not_before(x: float) -> None:
    assert first_centre(x, 8) == sum(centre < x for centre in np.arange(8) + 0.5)
