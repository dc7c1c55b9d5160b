import numpy as np
import pytest

from hairpipe.body.blended_shapes import Cone, Ellipsoid, Stroke, axis_rotation, evaluate, gradient, project, smooth_min

CHANCE = np.random.default_rng(1)
POINTS = CHANCE.uniform(-2.0, 2.0, (200, 3))


def test_ball_has_its_exact_distance():
    ball = Ellipsoid((0.1, 0.2, 0.3), (0.5, 0.5, 0.5), (10.0, 20.0, 30.0))
    exact = np.linalg.norm(POINTS - (0.1, 0.2, 0.3), axis=1) - 0.5
    np.testing.assert_allclose(ball.distance(POINTS), exact, atol=1e-12)


def test_ellipsoid_vanishes_on_its_turned_surface():
    shape = Ellipsoid((0.1, 0.0, -0.2), (0.3, 0.5, 0.2), (15.0, -40.0, 70.0))
    unit = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
    turn = axis_rotation(2, 70.0) @ axis_rotation(1, -40.0) @ axis_rotation(0, 15.0)
    surface = unit * shape.radii @ turn.T + shape.centre
    np.testing.assert_allclose(shape.distance(surface), 0.0, atol=1e-12)


def test_cone_of_one_thickness_is_a_capsule():
    capsule = Cone((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.25, 0.25))
    nearest = np.clip(POINTS[:, 1], -1.0, 1.0)
    exact = np.linalg.norm(POINTS - nearest[:, None] * (0.0, 1.0, 0.0), axis=1) - 0.25
    np.testing.assert_allclose(capsule.distance(POINTS), exact, atol=1e-12)


def test_smooth_min_is_min_far_away_and_less_within():
    a, b = CHANCE.uniform(-1.0, 1.0, (2, 1000))
    mixed = smooth_min(a, b, 0.3)
    far = np.abs(a - b) >= 0.3
    np.testing.assert_array_equal(mixed[far], np.minimum(a, b)[far])
    assert (mixed[~far] < np.minimum(a, b)[~far]).all()
    assert (mixed >= np.minimum(a, b) - 0.05).all()  # width / 6 where both are equal


def test_carving_leaves_nothing_of_the_part():
    whole = Stroke(Ellipsoid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), 0.0)
    hole = Stroke(Ellipsoid((0.0, 0.0, 1.0), (0.5, 0.5, 0.5)), 0.05, carve=True)
    inside_hole = POINTS[np.linalg.norm(POINTS - (0.0, 0.0, 1.0), axis=1) < 0.5]
    assert len(inside_hole) > 0
    assert (evaluate((whole, hole), inside_hole) > 0.0).all()


def test_mirrored_parts_make_a_symmetric_field():
    strokes = (
        Stroke(Ellipsoid((0.0, 0.0, 0.0), (0.4, 0.5, 0.4)), 0.0),
        Stroke(Ellipsoid((0.5, 0.1, 0.2), (0.2, 0.3, 0.2), (5.0, 30.0, -10.0)), 0.1, mirror=True),
    )
    np.testing.assert_array_equal(evaluate(strokes, POINTS), evaluate(strokes, POINTS * (-1.0, 1.0, 1.0)))


@pytest.mark.parametrize("count", [1, 7, 40000])
def test_evaluation_in_chunks_equals_each_point_alone(count):
    strokes = (Stroke(Ellipsoid((0.0, 0.0, 0.0), (0.4, 0.5, 0.4)), 0.0),)
    points = CHANCE.uniform(-1.0, 1.0, (count, 3))
    pick = CHANCE.integers(0, count, 5)
    together = evaluate(strokes, points)
    np.testing.assert_allclose(together[pick], [evaluate(strokes, points[i : i + 1])[0] for i in pick], atol=1e-15)


def test_projection_lands_on_the_surface_along_the_gradient():
    ball = (Stroke(Ellipsoid((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)), 0.0),)
    outside = POINTS[np.linalg.norm(POINTS, axis=1) > 0.4]
    landed = project(ball, outside, steps=2)
    np.testing.assert_allclose(landed, 0.5 * outside / np.linalg.norm(outside, axis=1, keepdims=True), atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(gradient(ball, outside), axis=1), 1.0, atol=1e-6)
