"""Density of hair: all of it is on the grid, where it is; the shell of a ball of hair is that ball."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.sections import section_of
from hairpipe.groom.strands import unbound
from hairpipe.levelset.bake import bake
from hairpipe.nodes.carry_groom import carry_groom
from hairpipe.values import Density, Strands
from hairpipe.values.groom import strand_lengths
from hairpipe.volume.density import density_of, shell_of

CELL = 0.01


def hair_of(points, velocities=None):
    """Strands of points, (S, n, 3)."""
    flat = np.asarray(points, float).reshape(-1, 3)
    offsets = (np.arange(len(points) + 1) * len(points[0])).astype(np.int32)
    speeds = np.zeros(flat.shape) if velocities is None else velocities
    return Strands(flat, np.asarray(speeds, np.float32), offsets, 8e-5)


@pytest.fixture
def random_hair():
    rng = np.random.default_rng(8)
    return hair_of(np.cumsum(0.004 * rng.normal(size=(50, 12, 3)), axis=1), rng.normal(size=(600, 3)))


def test_all_hair_is_on_the_grid_and_moves_there(random_hair):
    density, points = density_of(random_hair, CELL), random_hair.points.astype(float)
    lengths = strand_lengths(points, random_hair.offsets)
    assert density.length.sum(dtype=float) * CELL**3 == pytest.approx(lengths.sum(), rel=1e-7)
    momentum = (density.length[..., None] * density.velocity.astype(float)).sum(axis=(0, 1, 2)) * CELL**3
    steps = np.linalg.norm(np.diff(points.reshape(50, 12, 3), axis=1), axis=2)
    shares = 0.5 * (np.pad(steps, ((0, 0), (1, 0))) + np.pad(steps, ((0, 0), (0, 1))))
    np.testing.assert_allclose(momentum, shares.ravel() @ random_hair.velocities, atol=1e-5 * np.abs(momentum).max())


def test_hair_moved_by_cells_has_its_density_moved(random_hair):
    by, cell = np.array([3, -2, 7]), 2.0**-7
    points = np.round(random_hair.points * 2**24) / 2**24  # so that shifts are exact
    here, there = (
        density_of(Strands(moved, random_hair.velocities, random_hair.offsets, 8e-5), cell)
        for moved in (points, points + by * cell)
    )
    np.testing.assert_array_equal(there.low, here.low + by)
    assert there.length.shape == here.length.shape
    assert there.length.tobytes() == here.length.tobytes() and there.velocity.tobytes() == here.velocity.tobytes()


def test_it_is_the_same_on_any_number_of_threads(random_hair, same_on_threads):
    same_on_threads(lambda: density_of(random_hair, CELL))


def test_no_straight_hair_is_lost_by_rounding():
    """From root to tip a straight hair may be longer than along its segments, in the last bit."""
    towards = np.random.default_rng(1).normal(size=(200, 3))
    towards *= 0.2 / np.linalg.norm(towards, axis=1, keepdims=True)
    density = density_of(hair_of(np.linspace(0.0, 1.0, 21)[None, :, None] * towards[:, None]), CELL)
    assert density.length.sum(dtype=float) * CELL**3 == pytest.approx(200 * 0.2, rel=1e-7)


def test_the_middle_of_an_even_bundle_has_one_hair_for_each_square(random_hair):
    """Parallel hairs a millimetre apart: 1e6 metres in a cubic metre."""
    x, z = np.meshgrid(np.arange(40) * 1e-3, np.arange(40) * 1e-3)
    roots = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], axis=1)
    hair = hair_of(roots[:, None] + np.linspace(0.0, -0.1, 21)[None, :, None] * np.array([0.0, 1.0, 0.0]))
    section, extent = section_of(density_of(hair, CELL), 1, -0.05)
    assert section[2, 2] == pytest.approx(1e6, rel=1e-4)
    assert extent[0] <= 0.0 and extent[1] >= 0.039
    assert not section_of(density_of(hair, CELL), 1, 0.5)[0].any()


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_hair_that_is_not_finite_is_omitted(random_hair, wrong):
    points = random_hair.points.copy()
    points[5, 1] = wrong
    rest = Strands(points[12:], random_hair.velocities[12:], random_hair.offsets[:-1], 8e-5)
    with_it = density_of(Strands(points, random_hair.velocities, random_hair.offsets, 8e-5), CELL)
    np.testing.assert_array_equal(with_it.length, density_of(rest, CELL).length)
    nothing = density_of(Strands(points[:12], random_hair.velocities[:12], random_hair.offsets[:2], 8e-5), CELL)
    assert nothing.length.size == 0
    assert section_of(nothing, 0, 0.0)[0].size == 0


POWER, RADIUS = 2.0**-7, 0.06
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
    shell = shell_of(density_of(ball, POWER), 1.0, 0.5)
    facts = measure_mesh(shell.points, shell.triangles)
    assert facts["closed"] and facts["euler"] == 2
    assert facts["volume"] == pytest.approx(4.0 / 3.0 * np.pi * RADIUS**3, rel=0.05)
    assert np.linalg.norm(shell.points, axis=1) == pytest.approx(np.full(len(shell.points), RADIUS), abs=0.2 * POWER)


def test_less_density_lies_farther_out_and_blurred_more_the_farther(ball):
    density = density_of(ball, POWER)
    sizes = [np.linalg.norm(shell_of(density, *how).points, axis=1).mean() for how in ((1, 0.5), (1, 0.2), (2, 0.2))]
    assert sizes[0] < sizes[1] < sizes[2]


def test_it_moves_as_the_hair_does(ball):
    """What is seen at the border of hair lies within it, by about the blur: it turns with a smaller radius."""
    shell = shell_of(density_of(ball, POWER), 1.0, 0.5)
    assert shell.rates == pytest.approx(np.cross(SPIN, shell.points) + TRAVEL, abs=1.5 * POWER * SPIN[1])
    gliding = Strands(ball.points, np.tile(np.float32(TRAVEL), (len(ball.points), 1)), ball.offsets, ball.diameter)
    rates = shell_of(density_of(gliding, POWER), 1.0, 0.5).rates
    assert rates == pytest.approx(np.tile(TRAVEL, (len(rates), 1)), abs=1e-6)


def test_hair_moved_by_cells_has_its_shell_moved(ball):
    by = np.array([3, -2, 7])
    points = np.round(ball.points * 2**24) / 2**24  # so that shifts are exact
    here, there = (
        shell_of(density_of(Strands(moved, ball.velocities, ball.offsets, ball.diameter), POWER), 2.0, 0.2)
        for moved in (points, points + by * POWER)
    )
    assert len(there.triangles) == len(here.triangles)  # squares may be cut along either diagonal, by the last bit
    assert there.points == pytest.approx(here.points + by * POWER, abs=1e-14)


def test_its_signed_distance_has_a_gradient_of_one(ball):
    surface = bake(shell_of(density_of(ball, POWER), 2.0, 0.2), POWER, 8.0, "refuse")
    steps = np.stack(np.gradient(surface.distance.astype(float), POWER, axis=(1, 2, 3)))[:, :, 1:-1, 1:-1, 1:-1]
    near = np.abs(surface.distance[:, 1:-1, 1:-1, 1:-1]) < 3.0 * POWER
    assert near.sum() > 1000
    assert np.linalg.norm(steps, axis=0)[near] == pytest.approx(np.ones(near.sum()), abs=0.05)


def test_no_hair_and_a_level_beyond_all_of_it_are_refused(ball):
    nothing = Density(np.zeros(3, np.int32), POWER, np.zeros((0, 0, 0), np.float32), np.zeros((0, 0, 0, 3), np.float32))
    with pytest.raises(BadInput, match="there is no hair"):
        shell_of(nothing, 1.0, 0.2)
    with pytest.raises(BadInput, match=r"no density reaches 5 of the median"):
        shell_of(density_of(ball, POWER), 1.0, 5.0)
