"""Errors of rounding in a body change no root."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.bust import EARS, HAIRLINE, build_bust
from hairpipe.body.scalp import Scalp, height_above, paint_scalp
from hairpipe.groom.seeding import power_of_two, rounded, rounded_density, rounded_mesh, seed_roots
from hairpipe.nodes.load_body import load_body
from hairpipe.values import Mesh
from hairpipe.values.triangles import blend_corners, site_points, unit_normals

ERROR = 1e-12  # of points [m], a thousand times and more of what processors and versions of numpy differ by


def painted(mesh, values):
    corners = values[mesh.triangles]
    return lambda sites: blend_corners(corners[sites.triangles], sites)


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
