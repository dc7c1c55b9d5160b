"""The Kirchhoff rod against the elastica, closed forms and the laws it must keep."""

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from scipy.special import fresnel

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.theory.clamps import Clamp, hang_rod, span_rod
from hairpipe.graphs.experiments.studies.theory.driven_rods import driven_rod, rod_of
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.graphs.experiments.studies.theory.kirchhoff import Rod
from hairpipe.graphs.experiments.studies.theory.rod_frames import frames_of
from hairpipe.groom.strands import lay_strands

GJ = 0.74
NOTHING = np.zeros(3)


def clamp_along(tangent: np.ndarray, roll: float = 0.0) -> Clamp:
    across = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent))])
    across /= np.linalg.norm(across)
    frame = np.column_stack([across, np.cross(tangent, across), tangent])
    return Clamp(NOTHING, frame @ Rotation.from_rotvec([0, 0, roll]).as_matrix())


def helix(radius: float, pitch: float, turns: float) -> tuple[Rod, Clamp, np.ndarray]:
    """A helix around the y axis, going down, its pitch angle [rad], with a clamp, and a point on its axis."""
    bend, twist = np.cos(pitch) ** 2 / radius, np.sin(pitch) * np.cos(pitch) / radius
    rod = Rod(2 * np.pi * turns * radius / np.cos(pitch), 1.0, GJ, np.array([bend, 0.0, twist]), NOTHING)
    down, out = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    d3 = np.sin(pitch) * down + np.cos(pitch) * out
    d1 = np.cos(pitch) * down - np.sin(pitch) * out
    frame = np.column_stack([d1, np.cross(d3, d1), d3])
    return rod, Clamp(NOTHING, frame), -radius * frame[:, 1]


@pytest.mark.parametrize(("gamma", "inclination"), [(1.0, 0.0), (100.0, 45.0), (1000.0, -45.0)])
def test_in_a_plane_it_is_the_elastica(gamma, inclination):
    angle = np.deg2rad(inclination)
    rod = Rod(1.0, 1.0, GJ, NOTHING, np.array([0, -gamma, 0]))
    shape = hang_rod(rod, clamp_along(np.array([np.cos(angle), np.sin(angle), 0]), roll=0.7))
    np.testing.assert_allclose(shape.points[-1], [*bend_elastica(gamma, angle).tip, 0], atol=1e-8)


def test_frames_stay_rotations_and_the_tangent_is_the_slope():
    rod, clamp, _ = helix(0.01, 0.4, 2.3)
    shape = hang_rod(Rod(rod.length, 8e-9, 6e-9, rod.natural, np.array([0, 0, -6e-5])), clamp)
    np.testing.assert_allclose(np.linalg.det(shape.frames), 1, atol=1e-6)
    slope = np.gradient(shape.points, shape.arc, axis=0, edge_order=2)
    np.testing.assert_allclose(slope, shape.frames[:, :, 2], atol=1e-3)
    np.testing.assert_allclose(shape.frames, frames_of(shape.quaternions.T))


def test_without_load_a_curl_keeps_its_shape():
    rod, clamp, centre = helix(0.01, 0.3, 3)
    shape = hang_rod(rod, clamp)
    np.testing.assert_allclose(shape.points[-1], [0, -0.01 * np.tan(0.3) * 6 * np.pi, 0], atol=1e-7)
    assert np.abs(shape.couple).max() < 1e-6 and np.abs(shape.force).max() < 1e-6
    radii = np.linalg.norm((shape.points - centre)[:, [0, 2]], axis=1)
    np.testing.assert_allclose(radii, 0.01, atol=1e-7)


def test_without_load_a_rod_whose_curvature_grows_is_the_spiral_of_cornu():
    rate = 9.0
    rod = Rod(1.3, 1.0, GJ, np.array([0.0, 0.0, 0.0]), NOTHING, growth=np.array([0.0, rate, 0.0]))
    shape = hang_rod(rod, Clamp(NOTHING, np.eye(3)))
    unit = np.sqrt(np.pi / rate)
    aside, along = (unit * part for part in fresnel(rod.length / unit))
    np.testing.assert_allclose(shape.points[-1], [aside, 0.0, along], atol=1e-7)


def test_it_balances_its_weight_at_every_section():
    rod = Rod(1.0, 1.0, GJ, np.array([0.0, 1.0, 4.0]), np.array([0.0, 3.0, 5.0]), growth=np.array([0.0, 8.0, 0.0]))
    shape = hang_rod(rod, Clamp(NOTHING, np.eye(3)))
    beyond = rod.length - shape.arc
    np.testing.assert_allclose(shape.force, beyond[:, None] * rod.weight, atol=1e-8)
    middle = CubicSpline(shape.arc, shape.points).antiderivative()
    centres = middle(rod.length) - middle(shape.arc) - beyond[:, None] * shape.points
    np.testing.assert_allclose(shape.couple, np.cross(centres, rod.weight), atol=1e-5)
    body = np.einsum("nji,nj->ni", shape.frames, shape.couple)
    turned = Rotation.from_matrix(shape.frames[:-1]).inv() * Rotation.from_matrix(shape.frames[1:])
    rates = turned.as_rotvec() / np.diff(shape.arc)[:, None]
    means = (body[1:] + body[:-1]) / 2 / [1.0, 1.0, GJ]
    growth = rod.natural_at((shape.arc[1:] + shape.arc[:-1]) / 2).T
    np.testing.assert_allclose(rates, means + growth, atol=2e-2)


@pytest.mark.parametrize("pull", [0.3, 1.2])
def test_a_helix_pulled_along_its_axis_is_a_helix(pull):
    """Love 271: a wrench on the axis, force R and couple K, keeps curvature and twist the same all along:

    R = GJ (t - t^) cos a / r - EI (k - k^) sin a / r,   K = GJ (t - t^) sin a + EI (k - k^) cos a
    """
    rod, clamp, _ = helix(1.0, 0.2, 3)
    radius, angle = 0.9, 0.2 + pull / 3  # of the wanted helix
    bend, twist = np.cos(angle) ** 2 / radius, np.sin(angle) * np.cos(angle) / radius
    more_bend, more_twist = bend - rod.natural[0], GJ * (twist - rod.natural[2])
    force = (more_twist * np.cos(angle) - more_bend * np.sin(angle)) / radius
    couple = more_twist * np.sin(angle) + more_bend * np.cos(angle)
    wanted, turned, centre = helix(radius, angle, rod.length * np.cos(angle) / radius / (2 * np.pi))
    turn = clamp.frame @ turned.frame.T
    axis = turn @ np.array([0, -1.0, 0])
    tip = turn @ hang_rod(wanted, turned).points[-1]
    found = hang_rod(rod, clamp, force * axis, couple * axis + np.cross(turn @ centre - tip, force * axis))
    assert wanted.length == pytest.approx(rod.length)
    np.testing.assert_allclose(found.points[-1], tip, atol=1e-6 * rod.length)
    bending = found.couple - np.sum(found.couple * found.frames[:, :, 2], axis=1)[:, None] * found.frames[:, :, 2]
    np.testing.assert_allclose(np.linalg.norm(bending, axis=1), abs(more_bend), rtol=1e-4)


def test_a_flat_coil_is_the_spring_of_the_handbooks():
    """k = GJ / (2 pi r^3 N) as the pitch goes to zero (Love 272)."""
    radius, turns, down = 1.0, 5, np.array([0, -1.0, 0])
    rod, clamp, centre = helix(radius, 0.03, turns)
    free = hang_rod(rod, clamp).points[-1]
    force = 1e-4 * down
    pulled = hang_rod(rod, clamp, force, np.cross(centre + (free @ down) * down - free, force)).points[-1]
    assert 1e-4 / ((pulled - free) @ down) == pytest.approx(GJ / (2 * np.pi * radius**3 * turns), rel=2e-3)


def test_twist_is_proportional_to_the_torque():
    rod = Rod(0.1, 8e-9, 6e-9, NOTHING, NOTHING)
    start = clamp_along(np.array([0, -1.0, 0]))
    shape = hang_rod(rod, start, couple=6e-9 * 4.0 / 0.1 * start.frame[:, 2])
    turn = start.frame @ Rotation.from_rotvec([0, 0, 4.0]).as_matrix()
    np.testing.assert_allclose(shape.frames[-1], turn, atol=1e-6)
    np.testing.assert_allclose(shape.points[-1], [0, -0.1, 0], atol=1e-9)


def test_held_where_a_load_has_brought_it_it_needs_that_load():
    rod, clamp, _ = helix(0.01, 0.4, 1.5)
    heavy = Rod(rod.length, 8e-9, 6e-9, rod.natural, np.array([2e-5, -6e-5, 0]))
    force, couple = np.array([1e-6, -4e-6, 2e-6]), np.array([1e-8, 0, 2e-8])
    pulled = hang_rod(heavy, clamp, force, couple)
    end = Clamp(pulled.points[-1], pulled.frames[-1])
    held = span_rod(heavy, clamp, end, hang_rod(heavy, clamp, force, 0.9 * couple))
    np.testing.assert_allclose(held.force[-1], force, rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(held.couple[-1], couple, rtol=1e-3, atol=1e-11)


def test_it_turns_with_the_world():
    rod, clamp, _ = helix(0.01, 0.3, 2)
    turn = Rotation.from_rotvec([0.4, -2.0, 1.1]).as_matrix()
    weight, force = np.array([1e-5, -6e-5, 0]), np.array([0, 0, 3e-6])
    here = hang_rod(Rod(rod.length, 8e-9, 6e-9, rod.natural, weight), clamp, force)
    there = hang_rod(
        Rod(rod.length, 8e-9, 6e-9, rod.natural, turn @ weight), Clamp(NOTHING, turn @ clamp.frame), turn @ force
    )
    np.testing.assert_allclose(there.points[-1], turn @ here.points[-1], atol=1e-8)


def test_a_rod_pushed_beyond_all_reach_is_refused():
    rod = Rod(1.0, 1.0, GJ, NOTHING, np.array([np.nan, 0, 0]))
    with pytest.raises(ArithmeticError, match="equilibrium"):
        hang_rod(rod, clamp_along(np.array([1.0, 0, 0])))


LENGTH, FPS = 0.1, 10.0
BENDING, TORSION = 8e-9, 6e-9
GROOM = lay_strands(1, LENGTH, 40, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.002)


def measured(frames: int, **track) -> dict[str, np.ndarray]:
    tips = Track(**track, ease="linear")
    ends = {n: drive(GROOM, n / FPS, Track(), None, tips, None) for n in range(frames)}
    table = driven_rod(GROOM, ends, FPS, BENDING, TORSION)
    return {name: np.asarray(table[name]) for name in table.names}


def test_pushed_it_is_the_elastica():
    """Clamped at both ends, span / L = 2 E / K - 1 and bulge / L = k / K for some k (Love, 263)."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipk

    found = measured(13, times=(0.0, 1.2), move=((0.0, 0.0, 0.0), (-0.5 * LENGTH, 0.0, 0.0)))
    assert len(found["span [m]"]) == 13
    for span, bulge in zip(found["span [m]"][4:] / LENGTH, found["bulge [m]"][4:] / LENGTH, strict=True):
        m: Any = brentq(lambda m, span=span: 2 * ellipe(m) / ellipk(m) - 1 - span, 1e-6, 0.9)
        assert bulge == pytest.approx(np.sqrt(m) / ellipk(m), rel=2e-3)
    assert abs(found["writhe [1]"]).max() < 1e-6


def test_twisted_it_winds_the_way_it_is_turned():
    slack = ((0.0, 0.0, 0.0), (-0.1 * LENGTH, 0.0, 0.0), (-0.1 * LENGTH, 0.0, 0.0))
    found = [measured(8, times=(0.0, 0.4, 0.7), move=slack, turn=(0, 0, turn), axis=(1, 0, 0)) for turn in (60, -60)]
    for table, sign in zip(found, (1.0, -1.0), strict=True):
        writhe = sign * table["writhe [1]"]
        assert (np.diff(writhe[4:]) > 0.002).all() and np.ptp(writhe[:5]) < 1e-9
        np.testing.assert_allclose(table["turned [rad]"][-1], sign * np.radians(60.0))
    np.testing.assert_allclose(found[0]["bulge [m]"], found[1]["bulge [m]"], rtol=1e-5)
    assert found[0]["bulge [m]"][-1] < found[0]["bulge [m]"][4]


def test_beyond_its_length_there_is_no_equilibrium():
    with pytest.raises(BadInput, match="no equilibrium"):
        measured(1, times=(0.0,), move=((0.04 * LENGTH, 0.0, 0.0),))


def test_a_straight_strand_makes_a_straight_rod():
    straight = lay_strands(1, LENGTH, 10, (0.0, 1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    rod, start = rod_of(straight.points, BENDING, TORSION)
    assert not rod.natural.any() and rod.length == pytest.approx(LENGTH)
    np.testing.assert_allclose(start.frame.T @ start.frame, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(start.frame[:, 2], [0.0, 1.0, 0.0])
