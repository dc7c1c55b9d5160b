"""Strands that touch themselves or begin bent: knots are knots, and tables have the errors of closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.engine import Frames, Pair, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_knot import measure_knot
from hairpipe.graphs.experiments.nodes.measure_plectoneme import measure_plectoneme
from hairpipe.graphs.experiments.nodes.simulate_bent import model_bent, simulate_bent
from hairpipe.graphs.experiments.studies.knots.plectoneme import tension_of, torque_of
from hairpipe.graphs.experiments.studies.knots.shape import tied_strand
from hairpipe.groom.strands import lay_strands
from hairpipe.shot.settings import HairSettings, Scene
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

TIME = Time(1, 24.0)
MATERIAL = Material()


def second_invariant(points):
    """Return Vassiliev's invariant of order two of a long knot, (n, 3): 0 of a line, 1 of a trefoil, 3 of a cinquefoil.

    Polyak and Viro 1994: crossings A and B that are passed in the order A B A B, A first below and B first above, count
    with the product of their signs.
    """
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    points = points @ turn
    a, b = points[:-1], points[1:]
    crossings = []
    for i in range(len(a)):
        for j in range(i + 2, len(a)):
            matrix = np.column_stack([b[i] - a[i], a[j] - b[j]])[:2]
            if not np.linalg.det(matrix):  # parallel: the tails
                continue
            s, t = np.linalg.solve(matrix, (a[j] - a[i])[:2])
            if 0 < s < 1 and 0 < t < 1:
                first_above = (a[i] + s * (b[i] - a[i]))[2] > (a[j] + t * (b[j] - a[j]))[2]
                sign = np.sign(np.linalg.det(matrix)) * (1 if first_above else -1)
                crossings.append((i + s, j + t, first_above, sign))
    return sum(
        sign * other
        for first, last, above, sign in crossings
        for begin, end, above_too, other in crossings
        if first < begin < last < end and not above and above_too
    )


@pytest.mark.parametrize(("crossings", "invariant"), [(1, 0), (3, 1), (5, 3)])
def test_a_strand_is_tied_in_the_knot_of_its_crossings(crossings, invariant):
    points = tied_strand(0.6, 80, 0.06, 3e-3, crossings).points
    assert second_invariant(points) == invariant
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert lengths == pytest.approx(np.full(80, 0.6 / 80), rel=1e-9)
    tails = points[[1, 2, -2, -1]]
    assert points[0] == pytest.approx(np.zeros(3)) and tails[:, 1:] == pytest.approx(np.zeros((4, 2)), abs=1e-9)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ((0.6, 80, 0.06, 5e-3, 2), "crossings = 2"),
        ((0.3, 80, 0.06, 5e-3, 3), "longer"),
        ((0.6, 80, 0.01, 5e-3, 3), "larger"),
    ],
)
def test_an_impossible_knot_is_refused(settings, message):
    with pytest.raises(BadInput, match=message):
        tied_strand(*settings)


def test_torque_and_tension_of_a_coil_make_its_energy_stationary():
    bending, radius, angle = 3e-9, 2e-3, 0.31
    torque, tension = torque_of(angle, bending, radius), tension_of(angle, bending, radius)

    def energy(at):
        theta, coiled = at
        bent = 0.5 * bending * (np.sin(theta) ** 2 / radius) ** 2
        return coiled * (bent + tension - torque * np.sin(2 * theta) / (2 * radius))

    slope = approx_fprime(np.array([angle, 0.1]), energy, 1e-7)
    assert slope == pytest.approx([0.0, 0.0], abs=1e-5 * tension)


def states_of(points, tension):
    """Return a chain at points [m], (n+1, 3), with one tension [N], as two frames of a run."""
    segments = len(points) - 1
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    groom = lay_strands(1, length, segments, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    state = start(build_hair(groom, MATERIAL, "chain"), None, Scene())
    changed = replace(state, positions=state.positions.copy(), tensions=state.tensions.copy())
    changed.positions[1:] = points[:, :, None]  # below the row that continues the root
    changed.tensions[:, 0] = tension
    return groom, Frames((1, 2), {1: changed, 2: changed}.__getitem__)


@pytest.mark.parametrize(("factor", "error"), [(1.0, 0.0), (1.3, 30.0)])
def test_a_loop_has_the_tension_of_a_thin_rod(factor, error):
    points = tied_strand(0.6, 80, 0.06, 5e-3, 3).points
    radius = (0.6 - np.linalg.norm(points[-1] - points[0])) / (2 * np.pi)
    tension = 0.5 * MATERIAL.bending / radius**2
    table = measure_knot(*states_of(points, factor * tension), TIME, material=MATERIAL)
    assert len(table["radius [mm]"]) == 1 and table["radius [mm]"] == pytest.approx([1e3 * radius])
    assert table["tension error [%]"] == pytest.approx([error], abs=1e-9)


def test_a_circle_without_tension_balances_tails_that_pull_as_it_bends():
    circle = 0.3 / (2 * np.pi)
    angles = np.radians(3.0 + 6.0 * np.arange(60))
    bent = np.cumsum(0.005 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(60)]), axis=0)
    tail = 0.005 * np.arange(1, 31)[:, None] * [1.0, 0.0, 0.0]
    points = np.concatenate([tail - tail[-1], bent, bent[-1] + tail])
    groom, states = states_of(points, 0.5 * MATERIAL.bending / circle**2)
    for state in (states[1], states[2]):
        state.tensions[20:100] = 0.0
    assert measure_knot(groom, states, TIME, material=MATERIAL)["loop error [%]"] == pytest.approx([0.0], abs=0.2)


@pytest.mark.parametrize("angle", [0.2, 0.3])
def test_twist_that_no_writhe_takes_has_the_torque_of_a_coil(angle):
    radius, length = 2e-3, 0.3
    torque = torque_of(angle, MATERIAL.bending, radius)
    turned = np.degrees(1.1 * torque * length / MATERIAL.torsion)
    points = np.linspace(0.0, length, 31)[:, None] * [1.0, 0.0, 0.0]
    groom, states = states_of(points, tension_of(angle, MATERIAL.bending, radius))
    table = measure_plectoneme(groom, states, TIME, turned=turned, thickness=2 * radius, material=MATERIAL)
    assert table["angle [deg]"] == pytest.approx([np.degrees(angle)])
    assert table["torque error [%]"] == pytest.approx([10.0], abs=1e-6)


SETTINGS = HairSettings(model="rod", gravity=0.0, precision="double")
CHANGED = {name: getattr(SETTINGS, name) for name in ("model", "gravity", "precision")}


def strand(arch, segments=10):
    """Lay a strand of 10 cm with an arch."""
    return lay_strands(1, 0.1, segments, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, arch)


def ends_of(groom, rest, frames):
    """Return the points of a strand with a rest shape at the first and at the last of some frames."""
    model = model_bent(groom, rest, SETTINGS.material, SETTINGS.model, SETTINGS.construction)
    ends = drive(groom, 0.0, Track(), None, None, None)
    state, seen = None, []
    for frame in range(frames):
        hair = simulate_bent(groom, rest, Pair(ends, ends), state, Time(frame, 24.0), model, **CHANGED)
        state = hair.state
        seen.append(hair.strands.points)
    return seen[0], seen[-1]


def bow(points):
    """Return how much nearer the ends of a strand are than it is long, as a part of its length."""
    return 1.0 - np.linalg.norm(points[-1] - points[0]) / np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def test_a_bent_strand_straightens_to_its_rest_shape_and_a_groom_stays():
    arched = strand(0.4)
    begun, ended = ends_of(arched, strand(0.0), 13)
    assert begun == pytest.approx(arched.points) and bow(begun) > 0.1
    assert bow(ended) < 0.01 * bow(begun)
    _, kept = ends_of(arched, arched, 3)
    assert kept == pytest.approx(arched.points, abs=1e-9)


def test_a_rest_shape_of_another_cut_is_refused():
    with pytest.raises(BadInput, match="other strands or segments"):
        model_bent(strand(0.4), strand(0.0, 9), SETTINGS.material, SETTINGS.model, SETTINGS.construction)
