"""Roots: even, as dense as painted, on the scalp. Turk 1992; acceptance row 21."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from hairpipe.body.bust import build_bust
from hairpipe.errors import BadInput
from hairpipe.groom.seeding import seed_roots
from hairpipe.values import Mesh
from hairpipe.values.triangles import Sites, area_vectors, blend_corners, site_points


def painted(mesh, values):
    corners = values[mesh.triangles]
    return lambda sites: blend_corners(corners[sites.triangles], sites)


def uniform(sites):
    return np.ones(len(sites.triangles))


def seed(mesh, density, count, seed=0):
    return seed_roots(mesh, density, count, np.random.default_rng(seed))


def spacing_variation(points, density=1.0):
    """Coefficient of variation of the distance to the nearest neighbour, in units of the local spacing."""
    distance = cKDTree(points).query(points, 2)[0][:, 1] * np.sqrt(density)
    return distance.std() / distance.mean()


def density_correlation(mesh, values, points, patches=40):
    """Correlation of what was painted with what was placed, in patches of the surface."""
    centres = site_points(mesh, seed(mesh, uniform, patches))
    area = np.linalg.norm(area_vectors(mesh), axis=1)
    patch = cKDTree(centres).query(mesh.points[mesh.triangles].mean(axis=1))[1]
    size = np.bincount(patch, area, patches)
    wanted = np.bincount(patch, area * values[mesh.triangles].mean(axis=1), patches) / size
    placed = np.bincount(cKDTree(centres).query(points)[1], minlength=patches) / size
    return np.corrcoef(wanted, placed)[0, 1]


def random_sites(mesh, count):
    random = np.random.default_rng(0)
    area = np.linalg.norm(area_vectors(mesh), axis=1)
    triangles = random.choice(len(area), count, p=area / area.sum()).astype(np.int32)
    return Sites(triangles, random.dirichlet([1, 1, 1], count))


@pytest.mark.parametrize("count", [300, 2500, 8000])
@pytest.mark.parametrize("level", [1, 3, 5])
def test_distances_of_neighbours_vary_by_less_than_five_percent_on_any_mesh(sphere, level, count):
    mesh = sphere(0.1, level=level)
    for number in range(2):
        assert spacing_variation(site_points(mesh, seed(mesh, uniform, count, number))) < 0.05


def test_they_do_on_a_head_up_to_its_hairline():
    bust = build_bust()
    scalp = painted(bust.mesh, bust.maps["scalp"])
    points = site_points(bust.mesh, seed(bust.mesh, lambda sites: (scalp(sites) > 0.5).astype(float), 4000))
    assert spacing_variation(points) < 0.05


def test_random_roots_are_not_even(sphere):
    mesh = sphere(0.1, level=4)
    assert abs(spacing_variation(site_points(mesh, random_sites(mesh, 2500))) - 0.52) < 0.03


def test_roots_on_part_of_a_head_are_even_up_to_its_border(ball):
    density = painted(ball.mesh, ball.maps["scalp"])
    assert spacing_variation(site_points(ball.mesh, seed(ball.mesh, density, 1500))) < 0.2


def test_large_and_small_triangles_do_not_show():
    bands = np.concatenate([np.linspace(0, 0.5, 3), np.linspace(0.5, 1, 41)[1:]])
    x, y = np.meshgrid(bands, np.linspace(0, 1, 5))
    i, j = (g.ravel() for g in np.meshgrid(np.arange(len(bands) - 1), np.arange(4)))
    a = j * len(bands) + i
    b, c, d = a + 1, a + len(bands) + 1, a + len(bands)
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    mesh = Mesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), triangles)
    points = site_points(mesh, seed(mesh, uniform, 1000))
    assert spacing_variation(points) < 0.15
    assert abs(np.mean(points[:, 0] < 0.5) - 0.5) < 0.02


def test_roots_are_as_dense_as_painted(sphere):
    mesh = sphere(0.1, level=4)
    height = mesh.points[:, 1] / 0.1
    values = np.clip(0.55 + 0.45 * np.sin(4 * height) * mesh.points[:, 0] / 0.1, 0, 1)
    points = site_points(mesh, sites := seed(mesh, painted(mesh, values), 3000))
    assert density_correlation(mesh, values, points) > 0.95
    assert spacing_variation(points, painted(mesh, values)(sites)) < 0.15
    assert density_correlation(mesh, values, site_points(mesh, random_sites(mesh, 3000))) < 0.5


def test_no_root_leaves_the_scalp(ball):
    mesh, scalp = ball.mesh, ball.maps["scalp"]
    sites = seed(mesh, painted(mesh, scalp), 3000)
    assert (painted(mesh, scalp)(sites) > 0).all()
    assert (scalp[mesh.triangles[sites.triangles]].max(axis=1) > 0).all()


def test_no_root_enters_a_hole_painted_finer_than_the_triangles(sheet):
    mesh = sheet(3, 3)

    def ring(sites):
        x, y, _ = site_points(mesh, sites).T
        return (np.hypot(x - 0.5, y - 0.5) > 0.2).astype(float)

    sites = seed(mesh, ring, 800)
    assert len(sites.triangles) == 800 and ring(sites).all()


def test_roots_are_as_many_as_asked_and_lie_in_their_triangles(ball):
    for count in (1, 2, 777):
        sites = seed(ball.mesh, painted(ball.mesh, ball.maps["scalp"]), count)
        assert sites.triangles.shape == (count,) and sites.triangles.dtype == np.int32
        assert (sites.barycentrics >= 0).all() and np.allclose(sites.barycentrics.sum(axis=1), 1, atol=1e-12)


def test_the_same_seed_gives_the_same_roots_on_any_number_of_threads(ball, threads):
    density = painted(ball.mesh, ball.maps["scalp"])
    threads(1)
    one = seed(ball.mesh, density, 500)
    threads(2)
    two = seed(ball.mesh, density, 500)
    assert all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))
    assert not np.array_equal(one.barycentrics, seed(ball.mesh, density, 500, seed=1).barycentrics)


def test_nothing_painted_is_refused(ball):
    with pytest.raises(BadInput, match="zero everywhere"):
        seed(ball.mesh, painted(ball.mesh, np.zeros(len(ball.mesh.points))), 10)
