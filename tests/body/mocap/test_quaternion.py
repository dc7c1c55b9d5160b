import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from hairpipe.geometry.rotations import multiply, shortest_turn

CHANCE = np.random.default_rng(3)
vectors = arrays(float, 3, elements=st.floats(-1.0, 1.0)).filter(lambda v: np.linalg.norm(v) > 1e-3)


def unit(q: np.ndarray) -> np.ndarray:
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def test_products_agree_with_scipy():
    a, b = unit(CHANCE.normal(size=(2, 50, 4)))
    expected = Rotation.from_quat(np.roll(a, -1, axis=1)) * Rotation.from_quat(np.roll(b, -1, axis=1))
    product = Rotation.from_quat(np.roll(multiply(a, b), -1, axis=1))
    np.testing.assert_allclose(product.as_matrix(), expected.as_matrix(), atol=1e-12)


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
