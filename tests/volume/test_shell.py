"""The shell of a ball of hair is that ball."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.strands import unbound
from hairpipe.levelset.bake import bake
from hairpipe.nodes.carry_groom import carry_groom
from hairpipe.values import Density, Strands
from hairpipe.volume.density import density_of, shell_of

CELL, RADIUS = 2.0**-7, 0.06
SPIN, TRAVEL = np.array([0.0, 3.0, 0.0]), np.array([0.5, 0.0, -0.2])


@pytest.fixture(scope="module")
def ball() -> Strands:
    """Parallel hairs 3 mm apart, cut by a sphere about the origin, turning and travelling."""
    x, z = (a.ravel() for a in np.meshgrid(*[np.arange(-19.5, 20.0) * 0.003] * 2))
    x, z = (a[np.hypot(x, z) < RADIUS - 1e-4] for a in (x, z))
    half = np.sqrt(RADIUS**2 - x**2 - z**2)
    roots, ways = np.stack([x, half, z], axis=1), np.stack([0 * x, -2.0 * half, 0 * x], axis=1)
    points = roots[:, None] + np.linspace(0.0, 1.0, 9)[:, None] * ways[:, None]
    hair = carry_groom(unbound(points, np.tile(np.eye(3, 4), (len(x), 1, 1))), None, None)
    return Strands(hair.points, (np.cross(SPIN, hair.points) + TRAVEL).astype(np.float32), hair.offsets, hair.diameter)


def test_half_the_density_of_a_ball_is_its_surface(ball, measure_mesh):
    shell = shell_of(density_of(ball, CELL), 1.0, 0.5)
    facts = measure_mesh(shell.points, shell.triangles)
    assert facts["closed"] and facts["euler"] == 2
    assert facts["volume"] == pytest.approx(4.0 / 3.0 * np.pi * RADIUS**3, rel=0.05)
    assert np.linalg.norm(shell.points, axis=1) == pytest.approx(np.full(len(shell.points), RADIUS), abs=0.2 * CELL)


def test_less_density_lies_farther_out_and_blurred_more_the_farther(ball):
    density = density_of(ball, CELL)
    sizes = [np.linalg.norm(shell_of(density, *how).points, axis=1).mean() for how in ((1, 0.5), (1, 0.2), (2, 0.2))]
    assert sizes[0] < sizes[1] < sizes[2]


def test_it_moves_as_the_hair_does(ball):
    """What is seen at the border of hair lies within it, by about the blur: it turns with a smaller radius."""
    shell = shell_of(density_of(ball, CELL), 1.0, 0.5)
    assert shell.rates == pytest.approx(np.cross(SPIN, shell.points) + TRAVEL, abs=1.5 * CELL * SPIN[1])
    gliding = Strands(ball.points, np.tile(np.float32(TRAVEL), (len(ball.points), 1)), ball.offsets, ball.diameter)
    rates = shell_of(density_of(gliding, CELL), 1.0, 0.5).rates
    assert rates == pytest.approx(np.tile(TRAVEL, (len(rates), 1)), abs=1e-6)


def test_hair_moved_by_cells_has_its_shell_moved(ball):
    by = np.array([3, -2, 7])
    points = np.round(ball.points * 2**24) / 2**24  # so that shifts are exact
    here, there = (
        shell_of(density_of(Strands(moved, ball.velocities, ball.offsets, ball.diameter), CELL), 2.0, 0.2)
        for moved in (points, points + by * CELL)
    )
    assert len(there.triangles) == len(here.triangles)  # squares may be cut along either diagonal, by the last bit
    assert there.points == pytest.approx(here.points + by * CELL, abs=1e-14)


def test_its_signed_distance_has_a_gradient_of_one(ball):
    surface = bake(shell_of(density_of(ball, CELL), 2.0, 0.2), CELL, 8.0, "refuse")
    steps = np.stack(np.gradient(surface.distance.astype(float), CELL, axis=(1, 2, 3)))[:, :, 1:-1, 1:-1, 1:-1]
    near = np.abs(surface.distance[:, 1:-1, 1:-1, 1:-1]) < 3.0 * CELL
    assert near.sum() > 1000
    assert np.linalg.norm(steps, axis=0)[near] == pytest.approx(np.ones(near.sum()), abs=0.05)


def test_no_hair_and_a_level_beyond_all_of_it_are_refused(ball):
    nothing = Density(np.zeros(3, np.int32), CELL, np.zeros((0, 0, 0), np.float32), np.zeros((0, 0, 0, 3), np.float32))
    with pytest.raises(BadInput, match="there is no hair"):
        shell_of(nothing, 1.0, 0.2)
    with pytest.raises(BadInput, match=r"no density reaches 5 of the median"):
        shell_of(density_of(ball, CELL), 1.0, 5.0)
