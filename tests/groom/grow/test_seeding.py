"""Roots: even, as dense as painted, on the scalp, whatever errors of rounding. Turk 1992; acceptance row 21."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from hairpipe.body.bust import EARS, HAIRLINE, build_bust
from hairpipe.body.scalp import Scalp, height_above, paint_scalp
from hairpipe.errors import BadInput
from hairpipe.groom.seeding import (
    power_of_two,
    repulsion,
    rounded,
    rounded_density,
    rounded_mesh,
    seed_roots,
    sort_into_cells,
)
from hairpipe.nodes.load_body import load_body
from hairpipe.values import Mesh
from hairpipe.values.triangles import Sites, area_vectors, blend_corners, site_points, unit_normals


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


def test_the_same_seed_gives_the_same_roots_on_any_number_of_threads(ball, same_on_threads):
    density = painted(ball.mesh, ball.maps["scalp"])
    one = same_on_threads(lambda: seed(ball.mesh, density, 500))
    assert not np.array_equal(one.barycentrics, seed(ball.mesh, density, 500, seed=1).barycentrics)


def test_nothing_painted_is_refused(ball):
    with pytest.raises(BadInput, match="zero everywhere"):
        seed(ball.mesh, painted(ball.mesh, np.zeros(len(ball.mesh.points))), 10)


ERROR = 1e-12  # of points [m], a thousand times and more of what processors and versions of numpy differ by


def roots_on(body, count, seed):
    mesh = body.mesh
    sites = seed_roots(mesh, painted(mesh, body.maps["scalp"]), count, np.random.default_rng(seed))
    return site_points(mesh, sites)


def assert_roots_stay(make, count, seed, scale=1.0):
    """Compare the roots on a body with those on the body after errors; make builds it from errors of its points."""
    errors = np.random.default_rng(seed + 100).uniform(-ERROR, ERROR, (1_000_000, 3))
    apart = np.abs(roots_on(make(0.0 * errors), count, seed) - roots_on(make(errors), count, seed)).max()
    assert apart < 1e-9 * max(scale, 1.0)


@pytest.fixture(scope="module")
def bust():
    return build_bust()


@pytest.mark.parametrize(("scale", "seed"), [(1.0, 0), (1.0, 1), (0.01, 2), (100.0, 3)])
def test_rounding_errors_in_points_and_maps_of_the_bust_move_no_root(bust, scale, seed):
    def make(errors):
        points = bust.mesh.points + errors[: len(bust.mesh.points)]
        maps = {"scalp": height_above(HAIRLINE, points - np.array(EARS))}
        return replace(bust, mesh=Mesh(points * scale, bust.mesh.triangles), maps=maps)

    assert_roots_stay(make, 300, seed, scale)


@pytest.mark.parametrize("count", [1, 30, 2000])
def test_nor_do_those_of_a_sphere_of_a_scalp_with_a_sharp_border(ball, body_of, count):
    def make(errors):
        mesh = Mesh(ball.mesh.points + errors[: len(ball.mesh.points)], ball.mesh.triangles)
        return body_of(mesh, scalp=ball.maps["scalp"])

    assert_roots_stay(make, count, count)


@pytest.mark.parametrize("size", [1.0, 0.25, 0.3])
def test_nor_do_those_of_a_sheet_whose_coordinates_are_round_numbers(sheet, body_of, size):
    plain = sheet(8, 10)

    def make(errors):
        points = plain.points * size + errors[: len(plain.points)]
        return body_of(Mesh(points, plain.triangles), scalp=1.0 - errors[: len(points), 0])

    assert_roots_stay(make, 400, 0)


def test_nor_do_those_of_a_person_of_another_maker(shared):
    folder = shared / "body_makehuman"
    rig = {"skeleton": folder / "default.mhskel", "weights": folder / "default_weights.mhw"}
    person = load_body(file=folder / "base.obj", group="body", unit=0.1, **rig)

    def make(errors):
        mesh = Mesh(person.mesh.points + errors[: len(person.mesh.points)], person.mesh.triangles)
        moved = replace(person, mesh=mesh)
        return replace(moved, maps={"scalp": paint_scalp(moved, Scalp())})

    assert_roots_stay(make, 300, 0)


def test_a_rounded_mesh_keeps_the_side_that_its_triangles_face(bust):
    coarse = rounded_mesh(bust.mesh, bust.maps["scalp"][bust.mesh.triangles].any(axis=1))
    assert np.sum(unit_normals(bust.mesh) * unit_normals(coarse), axis=1).min() > 0.9
    assert 1e-5 < np.abs(coarse.points - bust.mesh.points).max() < 1e-4


def test_triangles_without_hair_do_not_coarsen_the_scalp(sphere, ball):
    """A scalp of small triangles and a floor of more and larger ones: the scalp is rounded as if alone."""
    fine, floor = ball.mesh, sphere(50.0, centre=(0.0, -60.0, 0.0), level=6)
    points, triangles = (
        np.concatenate([fine.points, floor.points]),
        (fine.triangles, floor.triangles + len(fine.points)),
    )
    bearing = np.arange(sum(map(len, triangles))) < len(fine.triangles)
    coarse = rounded_mesh(Mesh(points, np.concatenate(triangles)), bearing)
    assert np.array_equal(coarse.points[: len(fine.points)], rounded_mesh(fine, bearing[bearing]).points)


def test_numbers_that_people_write_are_not_where_two_steps_meet():
    decimal = np.arange(-2000, 2001) / 1000.0
    for step in 2.0 ** np.arange(-20, 1):
        for values in (decimal, step * np.arange(-9, 10) / 2.0):
            assert np.array_equal(rounded(values * (1 - 1e-12), step), rounded(values * (1 + 1e-12), step))
    for size in (1.0, 0.25, 0.5, 0.1, 64.0):
        assert power_of_two(size * (1 - 1e-12)) == power_of_two(size * (1 + 1e-12)) <= 1.5 * size


def test_a_rounded_density_is_0_where_it_was_and_within_a_step(ball):
    sites = None
    values = np.linspace(0.0, 3.0, 100)
    coarse = rounded_density(lambda given: values, 3.0)(sites)
    assert coarse[0] == 0.0 and np.array_equal(coarse, np.rint(coarse)) and coarse[-1] > 180
    assert np.abs(coarse * 3.0 / coarse[-1] - values).max() < 3.0 / 100


@pytest.fixture
def crowd():
    random = np.random.default_rng(3)
    points = random.normal(size=(400, 3)) * 0.3
    normals = random.normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return points, normals, random.uniform(0.05, 0.5, 400)


def brute_force(points, normals, reach):
    away = points[:, None] - points[None]
    d = np.linalg.norm(away, axis=2)
    r = np.minimum(reach[:, None], reach[None])
    weight = np.where((d > 0) & (d < r) & (normals @ normals.T > 0), (r - d) / np.where(d > 0, d, 1), 0.0)
    force = np.einsum("ij,ijk->ik", weight, away)
    return force - normals * np.sum(force * normals, axis=1, keepdims=True)


@pytest.mark.parametrize("size", [0.07, 0.5, 3.0])
def test_it_is_the_sum_over_all_pairs_for_any_cells(crowd, size):
    points, normals, reach = crowd
    found = repulsion(points, normals, reach, sort_into_cells(points, size, reach.max()))
    assert np.allclose(found, brute_force(points, normals, reach), atol=1e-12)
    assert np.abs(found).max() > 0.1


def test_on_a_plane_no_momentum_is_made(crowd):
    points, _, reach = crowd
    flat = points * (1.0, 1.0, 0.0)
    force = repulsion(flat, np.tile((0.0, 0.0, 1.0), (400, 1)), reach, sort_into_cells(flat, 0.2, reach.max()))
    assert np.abs(force.sum(axis=0)).max() < 1e-11


def test_points_in_one_place_do_not_push(threads):
    points, normals, reach = np.zeros((5, 3)), np.tile((0.0, 0.0, 1.0), (5, 1)), np.ones(5)
    assert not repulsion(points, normals, reach, sort_into_cells(points, 1.0, 1.0)).any()


def test_it_does_not_depend_on_the_number_of_threads(crowd, same_on_threads):
    points, normals, reach = crowd
    cells = sort_into_cells(points, 0.3, reach.max())
    same_on_threads(lambda: repulsion(points, normals, reach, cells))
