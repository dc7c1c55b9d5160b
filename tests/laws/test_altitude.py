"""The altitude spring, and the choice among the seven altitudes."""

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

from hairpipe.geometry.simd import load, store, width
from hairpipe.laws.altitude import linearise_altitude, shortest_altitude
from hairpipe.strands.assembly import add_tetrahedron

from .checks import check_law

K = 2.0
REST = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.3, 0.2, 1.1]])


@njit
def _add(A, b, x, inverse_heights):
    zero = 0.0 * load(x, (0, 0))
    spring = (zero, zero, zero), (zero, zero, zero, zero, zero, zero)
    add_tetrahedron(A, b, 0, linearise_altitude(x, 0, K, inverse_heights, 1.0, 1.0), spring, spring, spring)


def _apply(system, points, rest=REST):
    s = system(points)
    heights = _heights(rest)
    inverse = np.divide(1, heights, out=np.zeros(7), where=heights != 0)
    _add(s.A, s.b, s.x, np.repeat(inverse[None, :, None], 8, axis=2))
    return s


def _heights(points):
    """Signed lengths of the seven altitudes, from plane and line distances."""
    heights = []
    for i in range(4):
        a, b, c = (points[j] for j in range(4) if j != i)
        n = np.cross(b - a, c - a)
        heights.append(abs(n @ (points[i] - a)) / np.sqrt(n @ n))
    # N_1 + N_2 is the pair of edges (0, 3), (1, 2); N_1 + N_3 is (0, 2), (1, 3); N_2 + N_3 is (0, 1), (2, 3)
    for (i, j), (k, l) in (((0, 3), (1, 2)), ((0, 2), (1, 3)), ((0, 1), (2, 3))):
        n = np.cross(points[j] - points[i], points[l] - points[k])
        heights.append(abs(n @ (points[k] - points[i])) / np.sqrt(n @ n))
    volume = np.dot(np.cross(points[2] - points[0], points[3] - points[0]), points[1] - points[0])
    return np.sign(volume) * np.array(heights)


def _shortest(points):
    """Index and signed length of the shortest altitude."""
    heights = _heights(points)
    best = int(np.argmin(np.abs(heights)))
    return best, heights[best]


@pytest.mark.parametrize("seed", range(6))
def test_it_keeps_the_laws_of_the_shortest_altitude(system, seed):
    points = REST + 0.4 * np.random.default_rng(seed).normal(size=(4, 3))
    rest = _heights(REST)[_shortest(points)[0]]

    def energy(x):
        return K / 2 * (_shortest(x)[1] - rest) ** 2 / abs(rest)

    check_law(energy, lambda x: _apply(system, x).force, None, points, rtol=1e-5, atol=1e-6)


def test_rest_shape_and_its_rigid_copies_feel_nothing(system):
    turned = Rotation.from_rotvec([0.3, -1.0, 2.0]).apply(REST) + np.array([1, 2, 3])
    np.testing.assert_allclose(_apply(system, REST).force, 0, atol=1e-14)
    np.testing.assert_allclose(_apply(system, turned).force, 0, atol=1e-13)


def test_mirrored_rest_shape_gives_mirrored_force(system):
    mirror = np.array([1.0, 1.0, -1.0])
    points = REST + 0.2 * np.random.default_rng(3).normal(size=(4, 3))
    np.testing.assert_allclose(
        _apply(system, points * mirror, REST * mirror).force, _apply(system, points).force * mirror, atol=1e-13
    )


def test_force_is_no_larger_than_the_spring_s_own(system):
    rng = np.random.default_rng(11)
    for aspect in (1.0, 1e-3, 1e-6):
        for _ in range(20):
            points = rng.normal(size=(4, 3)) * [1, 1, aspect]
            best, height = _shortest(points)
            strain = height / _heights(REST)[best] - 1
            force = np.linalg.norm(_apply(system, points).force, axis=1)
            assert force.max() <= K * abs(strain) * (1 + 1e-6)


def test_particles_on_a_line_are_pushed_off_it_with_full_force(system):
    line = np.linspace(0, 1, 4)[:, None] * [1.0, 2.0, 3.0]
    for points in (line, line[[2, 0, 3, 1]], line[[0, 0, 1, 1]], line[[0, 1, 1, 1]], line[[1, 1, 1, 0]]):
        force = _apply(system, points).force
        assert np.linalg.norm(force, axis=1).sum() == pytest.approx(2 * K), "k on either side"
        np.testing.assert_allclose(force.sum(0), 0, atol=1e-12)
        np.testing.assert_allclose(force @ [1.0, 2.0, 3.0], 0, atol=1e-5)


def test_flat_tetrahedra_have_no_altitude_spring(system):
    s = _apply(system, REST, REST * [1, 1, 0])
    assert np.all(s.force == 0) and np.all(s.A == 0)


def test_particles_in_one_place_get_no_force(system):
    s = _apply(system, np.ones((4, 3)))
    assert np.all(s.force == 0) and np.all(s.A == 0)


RESTS = np.linspace(1.0, 1.6, 7)
TOLERANCE = 1e-6


@njit
def _sides(x, i):
    a = load(x, (i, 0, 0)), load(x, (i, 0, 1)), load(x, (i, 0, 2))
    u = load(x, (i, 1, 0)) - a[0], load(x, (i, 1, 1)) - a[1], load(x, (i, 1, 2)) - a[2]
    v = load(x, (i, 2, 0)) - a[0], load(x, (i, 2, 1)) - a[1], load(x, (i, 2, 2)) - a[2]
    w = load(x, (i, 3, 0)) - a[0], load(x, (i, 3, 1)) - a[1], load(x, (i, 3, 2)) - a[2]
    return u, v, w


@njit
def _chosen(x, rest, out):
    one = 0.0 * load(x, (0, 0, 0)) + 1.0
    rests = rest[0] * one, rest[1] * one, rest[2] * one, rest[3] * one, rest[4] * one, rest[5] * one, rest[6] * one
    for i in range(len(x)):
        u, v, w = _sides(x, i)
        weights, direction, height, kept = shortest_altitude(u, v, w, rests)
        for c in range(4):
            store(out, (i, c), weights[c])
        for c in range(3):
            store(out, (i, 4 + c), direction[c])
        store(out, (i, 7), height)
        store(out, (i, 8), kept)


def in_lanes(points):
    """Lay tetrahedra (n, 4, 3) in lanes, (blocks, 4, 3, W)."""
    return np.ascontiguousarray(points.reshape(-1, width(points.dtype), 4, 3).transpose(0, 2, 3, 1))


def evaluate(kernel, points, argument):
    """Weights (n, 4), directions (n, 3), heights and what the kernel adds of tetrahedra (n, 4, 3)."""
    x = in_lanes(points)
    out = np.empty((len(x), 9, x.shape[3]), points.dtype)
    kernel(x, argument, out)
    rows = out.transpose(0, 2, 1).reshape(-1, 9).astype(float)
    return rows[:, :4], rows[:, 4:7], rows[:, 7], rows[:, 8]


def choose(points):
    return evaluate(_chosen, points, RESTS.astype(points.dtype))


def excess(weights):
    """What the weights of two sides are beyond 0..1: 0 where none is negative, since those of each side sum to 1."""
    return np.abs(weights).sum(axis=1) - 2


def every_kind(count, rng, dtype="float64"):
    """Tetrahedra of many shapes and sizes, some of them flat, thin, collapsed or without any extent."""
    x = rng.normal(size=(count, 4, 3))
    kinds = np.array_split(np.arange(count), 14)
    least = np.log10(1e-6 if dtype == "float64" else 1e-2)
    for kind, part in enumerate(kinds):
        some = x[part]
        aspects = 10 ** rng.uniform(least, 0, (len(part), 1, 1))
        if kind == 1:
            some *= np.concatenate([np.ones((len(part), 1, 2)), aspects], axis=2)  # flat
        elif kind == 2:
            some *= np.concatenate([np.ones((len(part), 1, 1)), aspects, aspects], axis=2)  # needles
        elif kind == 3:
            some[:, :, 2] = 0.0
        elif kind == 4:
            some[:, 3] = some[:, 0]  # a collapsed edge
        elif kind == 5:
            some[:, 2], some[:, 3] = some[:, 0], some[:, 1]
        elif kind == 6:
            some[:, 1] = some[:, 0] + aspects[:, :, 0] * rng.normal(size=(len(part), 3))
        elif kind == 7:
            some[:] = rng.integers(-1, 2, size=some.shape)  # ties, coplanar, collinear, coincident
        elif kind == 8:
            some[:] = np.where(rng.random(some.shape) < 0.5, 0.0, 1.0)
        elif kind == 9:
            some[:] = some[:, :1] + rng.normal(size=(len(part), 4, 1)) * rng.normal(size=(len(part), 1, 3))  # lines
        elif kind == 10:
            some[:] = some[:, :1]  # one place
        elif kind == 11:
            some[:, 2] = some[:, 0] + some[:, 3] - some[:, 1]  # parallelograms
        elif kind == 12:
            some[:] = np.eye(4, 3) + aspects * some  # nearly regular
        x[part] = some * 10 ** rng.uniform(-4, 0, (len(part), 1, 1))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return (x @ turn).astype(dtype)


@pytest.mark.parametrize(
    ("dtype", "count", "tolerance"), [("float64", 1_000_000, TOLERANCE), ("float32", 80_000, 1e-2)]
)
@pytest.mark.kernels
def test_no_weight_is_negative_in_a_million_tetrahedra(dtype, count, tolerance):
    points = every_kind(count, np.random.default_rng(1), dtype)
    weights, direction, height, rest = choose(points)
    assert np.isfinite(weights).all() and np.isfinite(direction).all() and np.isfinite(height).all()
    assert excess(weights).max() < tolerance
    assert np.abs(weights.sum(axis=1)).max() < tolerance, "momentum"
    length = np.linalg.norm(direction, axis=1)
    assert np.all((np.abs(length - 1) < 1e-5) | (np.ptp(points, axis=1).max(axis=1) < 1e-12)), "a direction"
    assert np.isin(rest.astype(np.float32), RESTS.astype(np.float32)).all()


def test_forces_stay_within_five_percent_on_the_way_to_a_line():
    """A shape is made ever thinner, through where rounding takes over; where the choice changes hands it may jump."""
    rng = np.random.default_rng(4)
    steps = np.geomspace(1e-5, 1e-10, 8_000)
    along, across = rng.normal(size=(50, 1, 4, 1)), rng.normal(size=(50, 1, 4, 2))
    shapes = np.concatenate([np.broadcast_to(along, (50, 8_000, 4, 1)), steps[:, None, None] * across], axis=3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    weights, direction, height, kept = choose((shapes @ turn).reshape(-1, 4, 3))
    forces = (weights[:, :, None] * direction[:, None, :]).reshape(50, 8_000, 12)
    change = np.linalg.norm(np.diff(forces, axis=1), axis=2) / np.linalg.norm(forces[:, 1:], axis=2)
    switched = np.diff(kept.reshape(50, 8_000), axis=1) != 0
    assert change[~switched].max() < 0.05
    assert np.abs(height.reshape(50, 8_000)[:, -1]).max() < 1e-6
    assert switched.sum(axis=1).max() < 8
