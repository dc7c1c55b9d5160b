"""Bodies to grow hair on, small enough to know everything about."""

from collections.abc import Callable

import numpy as np
import pytest

from hairpipe.values import Body, Mesh, Skeleton


def make_body(mesh: Mesh, **maps: np.ndarray) -> Body:
    """A body of one joint."""
    n = len(mesh.points)
    skeleton = Skeleton(("root",), np.array([-1], np.int32), np.eye(4)[None], np.array([[0.0, 0.1, 0.0]]))
    return Body(mesh, skeleton, np.zeros((n, 1), np.int32), np.ones((n, 1)), maps)


@pytest.fixture(scope="session")
def body_of() -> Callable[..., Body]:
    return make_body


@pytest.fixture(scope="session")
def ball(sphere: Callable[..., Mesh]) -> Body:
    """A sphere of 0.1 m whose upper half is scalp."""
    mesh = sphere(0.1, level=5)
    return make_body(mesh, scalp=(mesh.points[:, 1] > 0.0).astype(float))
