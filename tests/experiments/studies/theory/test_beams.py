"""Theory of beams and of falling hair against other ways to find it."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.linalg import expm
from scipy.optimize import brentq, minimize

from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.droop_rod import droop_rod
from hairpipe.graphs.experiments.nodes.drop_ends import drop_ends
from hairpipe.graphs.experiments.studies.theory.beam_modes import bending_frequencies, bending_roots, bending_shape
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.graphs.experiments.studies.theory.falling import DENSITY, VISCOSITY, fallen
from hairpipe.graphs.experiments.studies.theory.twist_buckling import buckling_torque, buckling_twist
from hairpipe.groom.sampling import joined_strands
from hairpipe.groom.strands import lay_strands
from hairpipe.strands.material import Material


@pytest.mark.parametrize("clamp", [-45.0, 0.0, 45.0, 85.0])
@pytest.mark.parametrize("gamma", [0.1, 10.0, 1000.0])
def test_moment_balances_the_weight_beyond(gamma, clamp):
    """m(s) = -Gamma int_s^1 (x(t) - x(s)) dt, from the shape alone."""
    rod = bend_elastica(gamma, np.deg2rad(clamp))
    x = rod.points[:, 0]
    first = cumulative_trapezoid(x, rod.arc, initial=0)
    beyond = first[-1] - first - x * (1 - rod.arc)
    np.testing.assert_allclose(rod.moment, -gamma * beyond, atol=1e-4 * np.abs(rod.moment).max())
    assert trapezoid(rod.moment, rod.arc) == pytest.approx(rod.angle[-1] - rod.angle[0], rel=1e-3)


def test_tip_of_a_light_rod_sags_by_an_eighth():
    gamma = 1e-3
    np.testing.assert_allclose(bend_elastica(gamma).tip, [1.0, -gamma / 8], atol=1e-7)


@pytest.mark.parametrize("clamp", [-0.5, 0.0, 0.5])
def test_heavy_rod_hangs_but_for_a_layer_at_the_clamp(clamp):
    """There a'' = Gamma cos a, so a' = -sqrt(2 Gamma (1 + sin a)) and x = sqrt(2 (1 + sin clamp) / Gamma)."""
    gamma = 1e6
    assert bend_elastica(gamma, clamp).tip[0] == pytest.approx(np.sqrt(2 * (1 + np.sin(clamp)) / gamma), rel=2e-3)


@pytest.mark.parametrize(("gamma", "clamp"), [(3.0, 0.0), (30.0, 45.0)])
def test_chain_of_rigid_links_with_the_least_energy_agrees(gamma, clamp):
    """E = sum EI (a_i+1 - a_i)^2 / 2 l + weight; the clamp is half a link away; extrapolated from two resolutions."""
    start = np.deg2rad(clamp)

    def tip(links: int) -> np.ndarray:
        length = 1 / links
        carried = gamma * length**2 * (links - np.arange(links) - 0.5)

        def energy(angle: np.ndarray) -> tuple[float, np.ndarray]:
            turns = np.diff(angle, prepend=start)
            stiffness = np.full(links, 1 / length)
            stiffness[0] *= 2
            moment = stiffness * turns
            value = (moment @ turns) / 2 + carried @ np.sin(angle)
            return value, moment - np.append(moment[1:], 0) + carried * np.cos(angle)

        angle = minimize(energy, np.full(links, start), jac=True, method="BFGS", options={"gtol": 1e-7}).x
        return length * np.array([np.cos(angle).sum(), np.sin(angle).sum()])

    coarse, fine = tip(20), tip(40)
    np.testing.assert_allclose(fine + (fine - coarse) / 3, bend_elastica(gamma, start).tip, atol=2e-4)


def test_hanging_and_upright_rods_are_straight():
    np.testing.assert_allclose(bend_elastica(1000.0, -np.pi / 2).tip, [0, -1], atol=1e-12)
    np.testing.assert_allclose(bend_elastica(5.0, np.pi / 2).tip, [0, 1], atol=1e-12)


def test_lost_continuation_is_reported():
    with pytest.raises(ArithmeticError, match="no elastica"):
        bend_elastica(100.0, np.deg2rad(89.99))


def test_roots_are_those_of_the_tables():
    np.testing.assert_allclose(bending_roots(4), [1.8751041, 4.6940911, 7.8547574, 10.9955407], atol=1e-7)


def test_frequencies_are_eigenvalues_of_a_finely_divided_rod():
    """Cubic (Hermite) elements of EI y'''' = rho A w^2 y, clamped at one end."""
    length, bending, density, elements = 0.3, 8e-9, 6.5e-6, 20
    h = length / elements
    stiff = bending / h**3 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    mass = density * h / 420 * np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    K, M = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for e in range(0, 2 * elements, 2):
        K[e : e + 4, e : e + 4] += stiff
        M[e : e + 4, e : e + 4] += mass
    omega = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M[2:, 2:], K[2:, 2:])).real)[:3])
    np.testing.assert_allclose(bending_frequencies(3, length, bending, density), omega / 2 / np.pi, rtol=3e-5)


def test_shapes_swing_free_at_the_tip_and_are_orthogonal():
    s = np.linspace(0, 1, 4001)
    shapes = np.array([bending_shape(mode, s) for mode in range(3)])
    products = trapezoid(shapes[:, None] * shapes[None], s)
    np.testing.assert_allclose(products, np.eye(3), atol=1e-6)
    bends = np.gradient(np.gradient(shapes, s, axis=1), s, axis=1)
    assert np.abs(bends[:, -3]).max() < 0.05 * np.abs(bends).max()


def test_without_tension_it_is_the_tabled_one():
    """tan(M / 2) = M / 2, as for the column clamped at both ends (Greenhill 1883)."""
    half = brentq(lambda x: np.sin(x) - x * np.cos(x), np.pi, 1.5 * np.pi)
    assert buckling_torque() == pytest.approx(2 * half, rel=1e-10)


@pytest.mark.parametrize("tension", [-30.0, -5.0, 40.0, 400.0])
def test_a_neighbouring_shape_exists_just_there(tension):
    """The exact solution, carried from end to end: w'''' = i M w''' + P w'' with w = w' = 0 at both ends."""

    def gap(torque: float) -> float:
        step = np.diag(np.ones(3), 1).astype(complex)
        step[3, 2:] = tension, 1j * torque
        return np.linalg.svd(expm(step)[:2, 2:], compute_uv=False)[-1]

    found = buckling_torque(tension)
    assert gap(found) < 1e-8 * gap(0.9 * found)
    assert min(gap(part * found) for part in np.linspace(0.05, 0.95, 19)) > 1e-3 * gap(0.9 * found)


def test_a_taut_rod_buckles_as_an_endless_one():
    assert buckling_torque(1e4) == pytest.approx(2 * np.sqrt(1e4), rel=1e-3)


def test_thrust_alone_buckles_it():
    assert buckling_torque(-4 * np.pi**2 + 1e-3) < 0.1
    with pytest.raises(ValueError, match="thrust"):
        buckling_torque(-4 * np.pi**2)


def test_twist_follows_from_the_torque():
    assert buckling_twist(0.1, 8e-9, 6e-9) == pytest.approx(8.98682 * 8 / 6, rel=1e-5)


ASIDE, DOWN = (0.6, 0.0, 0.8), (0.0, -1.0, 0.0)


def laid(direction, length=0.03, segments=200):
    return lay_strands(1, length, segments, direction, (0.0, 0.0, 0.0), None, 0.0)


def test_little_weight_bends_as_a_beam():
    """The tip of a cantilever under its weight: q L^4 / (8 E I)."""
    material = Material()
    hair = droop_rod(laid(ASIDE), material=material)
    deflection = material.line_density * 9.81 * 0.03**4 / (8 * material.bending)
    assert hair.points[-1, 1] == pytest.approx(-deflection, rel=0.01)
    assert hair.points[-1, 0] / hair.points[-1, 2] == pytest.approx(0.75, rel=1e-5)


def test_its_length_and_its_clamp_are_those_of_the_groom():
    groom = joined_strands((laid(ASIDE, 0.3), laid((0.0, 0.5, 1.0), 0.1)))
    hair = droop_rod(groom)
    for first, last in zip(groom.offsets, groom.offsets[1:], strict=False):
        ours, theirs = hair.points[first:last].astype(float), groom.points[first:last]
        lengths = [np.linalg.norm(np.diff(p, axis=0), axis=1).sum() for p in (ours, theirs)]
        assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
        assert (ours[1] - ours[0]) @ (theirs[1] - theirs[0]) > 0.99 * np.sum((theirs[1] - theirs[0]) ** 2)


@pytest.mark.parametrize("direction", [DOWN, (0.0, 1.0, 0.0)])
def test_curves_out_of_a_plane_are_refused(direction):
    with pytest.raises(BadInput, match="strand 0 is bent or upright"):
        droop_rod(laid(direction))


HAIR = Material()


def test_a_damping_rate_has_its_closed_form():
    fall = fallen("rate", 0.3, HAIR, 8.0)
    left = np.exp(-8.0 * 0.3)
    assert fall.speed == pytest.approx(9.81 / 8.0 * (1.0 - left), rel=1e-8)
    assert fall.distance == pytest.approx(9.81 / 8.0 * (0.3 - (1.0 - left) / 8.0), rel=1e-8)


def test_the_drag_of_a_cylinder_carries_its_weight_at_the_terminal_speed():
    speed = fallen("across", 2.0, HAIR, 0.0).speed
    reynolds = DENSITY * HAIR.diameter * speed / VISCOSITY
    drag = 0.5 * DENSITY * HAIR.diameter * speed**2 * (1.18 + 6.8 * reynolds**-0.89 + 1.96 * reynolds**-0.5)
    assert drag == pytest.approx(9.81 * HAIR.line_density, rel=1e-6)
    faster = fallen("along", 4.0, HAIR, 0.0).speed
    friction = 0.25 * VISCOSITY * 6.8 * (DENSITY * HAIR.diameter * faster / VISCOSITY) ** 0.11
    assert friction * faster == pytest.approx(9.81 * HAIR.line_density, rel=1e-6) and faster > 3.0 * speed


def test_ends_fall_with_their_velocity_and_rest_before():
    groom = lay_strands(2, 0.1, 10, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    before, now, after = (drop_ends(groom, Time(n, 1000.0), at=5, law="across") for n in (5, 49, 51))
    assert not before.roots[:, :, 3].any() and not before.roots_rate.any()
    middle = drop_ends(groom, Time(50, 1000.0), at=5, law="across")
    np.testing.assert_allclose(500.0 * (after.roots - now.roots), middle.roots_rate, atol=1e-4)
    assert np.isnan(now.tips).all() and (now.roots[:, 1, 3] < -0.005).all()
