"""Hair on a ball, whose normals are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_normals import measure_normals
from hairpipe.levelset.bake import bake
from hairpipe.values import Normals, Strands

RADIUS = 0.06


@pytest.fixture(scope="module")
def ball(sphere):
    return bake(sphere(RADIUS), 0.005, 8.0, "refuse")


@pytest.fixture(scope="module")
def hair() -> Strands:
    """Strands of two points along circles of latitude on the ball."""
    rng = np.random.default_rng(4)
    roots = rng.normal(size=(2000, 3))
    roots *= RADIUS / np.linalg.norm(roots, axis=1, keepdims=True)
    ways = np.cross([0.0, 1.0, 0.0], roots)
    points = np.stack([roots, roots + 1e-4 * ways / np.linalg.norm(ways, axis=1, keepdims=True)], axis=1).reshape(-1, 3)
    return Strands(points, np.zeros(points.shape, np.float32), np.arange(0, 4001, 2, dtype=np.int32), 8e-5)


def measured(hair, vectors, ball):
    given = hair, Normals(vectors.astype(np.float32)), ball
    table = measure_normals(*(Frames((7,), {7: value}.__getitem__) for value in given))
    return {name.partition(" [")[0]: value for name, value in zip(table.names, next(table.rows()), strict=True)}


def test_normals_of_the_ball_are_those_of_its_shell(hair, ball):
    found = measured(hair, hair.points / RADIUS, ball)
    assert found["frame"] == 7 and found["carried, mean"] < 1.0 and found["terminator"] < 0.5
    assert found["behind, normals"] == 0.0 and found["gradient"] < 0.02


def test_kajiya_lights_what_lies_behind(hair, ball):
    """Along circles of latitude sin(t,l) is 1 from the poles; from aside, its mean over a cap of 60 degrees."""
    c, phi = (0.5 * (np.arange(400) + 0.5) / 400 + 0.5)[:, None], 2.0 * np.pi * np.arange(400) / 400
    aside = np.mean(c / np.sqrt(c**2 + (1.0 - c**2) * np.sin(phi) ** 2))
    found = measured(hair, hair.points / RADIUS, ball)["behind, Kajiya"]
    assert found == pytest.approx((2.0 + 4.0 * aside) / 6.0, abs=0.02) and found < 0.97


def test_normals_that_are_turned_by_an_angle_are_off_by_it(hair, ball):
    """A turn about an axis moves the terminators of lamps across it; of those along it, it moves none."""
    turned = Rotation.from_euler("y", 20.0, degrees=True).apply(hair.points / RADIUS)
    found = measured(hair, turned, ball)
    across = np.hypot(*(hair.points / RADIUS)[:, [0, 2]].T)
    exact = np.degrees(2.0 * np.arcsin(across * np.sin(np.radians(10.0))))
    assert found["carried, mean"] == pytest.approx(exact.mean(), abs=0.5)


def test_a_terminator_is_shifted_where_normals_lean_to_the_lamp(hair, ball):
    """Leaning to one pole, hair goes dark that much beyond the equator, by the one lamp earlier, by the other later."""
    leaning = hair.points / RADIUS + np.array([0.0, np.tan(np.radians(12.0)), 0.0])
    found = measured(hair, leaning / np.linalg.norm(leaning, axis=1, keepdims=True), ball)
    assert found["terminator"] == pytest.approx(12.0 / 3.0, abs=0.8)


def test_other_normals_and_other_hair_are_refused(hair, ball):
    with pytest.raises(BadInput, match="1 normals of 4000 points"):
        measured(hair, np.zeros((1, 3)), ball)
    with pytest.raises(BadInput, match="no hair is near"):
        measured(Strands(hair.points + 1.0, hair.velocities, hair.offsets, 8e-5), hair.points / RADIUS, ball)
