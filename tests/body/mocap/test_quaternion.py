import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from hairpipe.geometry.rotations import about_axis, multiply, shortest_turn, slerp, to_matrix

CHANCE = np.random.default_rng(3)
shares = st.floats(0.0, 1.0)
vectors = arrays(float, 3, elements=st.floats(-1.0, 1.0)).filter(lambda v: np.linalg.norm(v) > 1e-3)
rotations = arrays(float, 4, elements=st.floats(-1.0, 1.0)).filter(lambda q: np.linalg.norm(q) > 1e-2)


def unit(q: np.ndarray) -> np.ndarray:
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def turn_between(a: np.ndarray, b: np.ndarray) -> float:
    return Rotation.from_matrix(to_matrix(a).T @ to_matrix(b)).magnitude()


def test_matrices_and_products_agree_with_scipy():
    a, b = unit(CHANCE.normal(size=(2, 50, 4)))
    expected = Rotation.from_quat(np.roll(a, -1, axis=1)), Rotation.from_quat(np.roll(b, -1, axis=1))
    np.testing.assert_allclose(to_matrix(a), expected[0].as_matrix(), atol=1e-12)
    np.testing.assert_allclose(to_matrix(multiply(a, b)), (expected[0] * expected[1]).as_matrix(), atol=1e-12)


@pytest.mark.parametrize("axis", range(3))
def test_turn_about_an_axis_is_right_handed(axis):
    quarter = to_matrix(about_axis(np.eye(3)[axis], np.array(np.pi / 2.0)))
    np.testing.assert_allclose(quarter @ np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3], atol=1e-15)


@given(rotations, rotations, shares)
def test_slerp_turns_evenly_along_the_shorter_way(a, b, share):
    a, b = unit(a), unit(b)
    middle = slerp(a, b, np.array(share))
    assert np.linalg.norm(middle) == pytest.approx(1.0)
    whole = turn_between(a, b)
    assert turn_between(a, middle) == pytest.approx(share * whole, abs=1e-6)
    assert turn_between(middle, b) == pytest.approx((1.0 - share) * whole, abs=1e-6)


@given(vectors, vectors)
def test_shortest_turn_is_a_rotation_by_the_angle_between(start, end):
    turn = shortest_turn(start, end)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(turn @ unit(start), unit(end), atol=1e-6)
    angle = np.arctan2(np.linalg.norm(np.cross(start, end)), start @ end)
    assert Rotation.from_matrix(turn).magnitude() == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize("direction", np.vstack([np.eye(3), [[0.3, -0.2, 0.9]]]))
def test_shortest_turn_manages_opposite_directions(direction):
    turn = shortest_turn(direction, -direction)
    np.testing.assert_allclose(turn @ direction, -direction, atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)
