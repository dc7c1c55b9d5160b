"""What studies of accuracy measure, where the answer is known."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jv

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.accuracy import curls, helix, ring, spiral
from hairpipe.graphs.experiments.studies.accuracy.balanced import balanced_tables
from hairpipe.graphs.experiments.studies.accuracy.cantilever import cantilever_table
from hairpipe.graphs.experiments.studies.accuracy.column import GREENHILL, column_table, is_stable
from hairpipe.graphs.experiments.studies.accuracy.fan import fan_table, fanned
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Spiral
from hairpipe.graphs.experiments.studies.accuracy.specimen import (
    forces,
    moved,
    specimen_of,
    stiffness,
    straight_specimen,
)
from hairpipe.graphs.experiments.studies.accuracy.spiral import cut, rod_of, spiral_table
from hairpipe.graphs.experiments.studies.accuracy.statics import Balance, balance, motions
from hairpipe.graphs.experiments.studies.accuracy.torsion import held_length, torsion_table
from hairpipe.graphs.experiments.studies.accuracy.vibration import vibration_table
from hairpipe.graphs.experiments.studies.accuracy.writhe import writhe_tables
from hairpipe.graphs.experiments.studies.theory.clamps import hang_rod
from hairpipe.graphs.experiments.table.checks import checked
from hairpipe.graphs.experiments.validation.row import Row
from hairpipe.groom.strands import lay_strands
from hairpipe.strands.material import Material
from hairpipe.values import Strands

GUESSED, ROD = Sample(constants="guessed"), Sample(model="rod")


def test_a_calibrated_strand_sags_as_the_elastica_and_a_guessed_one_does_not():
    calibrated = cantilever_table(Sample(), [12], [0.0, 90.0], 2, [1.0, 2.0])
    guessed = cantilever_table(GUESSED, [12], [90.0], 1, [1.0])
    assert not calibrated["no equilibrium"].any()
    assert max(calibrated["tip error [% of length]"]) < 1.0 < guessed["tip error [% of length]"][0]


def test_hanging_rod_leaves_its_plane_where_theory_does_and_rises_to_its_height():
    assert abs(curls.hook_table(ROD, [25], [30.0])["error [%]"][0]) < 2.0
    assert abs(curls.coil_table(ROD, [25], [8.0])["error [%]"][0]) < 2.0
    assert abs(curls.height_table(ROD, [20], 8.0, 40.0)["error [% of length]"][0]) < 2.0


def test_hanging_rod_is_planar_outside_of_the_border_alone():
    shapes = curls.shape_table(ROD, 30, [6.0], [5.0, 20.0, 160.0])
    assert shapes.texts["shape"] == ("planar", "helix", "planar")


def test_balanced_rod_has_the_shape_of_the_table_and_its_modulus():
    shape, modulus = balanced_tables(ROD, [40])
    assert max(shape["error [% of D]"]) < 0.3
    assert abs(modulus["modulus error [%]"][0]) < 1.5


def test_a_chain_is_not_twisted():
    with pytest.raises(BadInput, match="cannot be twisted"):
        torsion_table(Sample(model="chain"), [5], [1.0])


def test_torque_is_that_of_the_rod_and_both_senses_are_tried():
    table = torsion_table(Sample(), [20], [0.05])
    np.testing.assert_allclose(table["twist [rad]"], [-0.05, 0.05])
    np.testing.assert_allclose(table["torque error [%]"], 0.0, atol=1.0)
    assert (table["tip shift [% of length per rad]"] < 2.0).all()  # of a rod it is nothing
    assert abs(torsion_table(GUESSED, [20], [0.05])["torque error [%]"][0]) > 10


@pytest.mark.parametrize("poisson", [0.35, 1.3])
def test_a_straight_rod_has_its_torque_exactly_and_its_tip_stays(poisson):
    table = torsion_table(Sample(model="rod", material=Material(poisson=poisson)), [8], [0.5, 4.0])
    np.testing.assert_allclose(table["torque error [%]"], 0.0, atol=1e-9)
    np.testing.assert_allclose(table["tip shift [% of length per rad]"], 0.0, atol=1e-9)


def test_frequencies_of_a_rod_err_by_the_square_of_its_segments():
    table = vibration_table(ROD, [10, 20], 1)
    coarse, fine = table["lower error [%]"]
    assert coarse / fine == pytest.approx(4.0, rel=0.02)
    np.testing.assert_allclose(table["upper error [%]"], [coarse, fine], rtol=1e-5)


def test_a_rod_writhes_closer_to_theory_the_finer_it_is():
    onset = writhe_tables(ROD, [10, 20])[1]
    coarse, fine = np.abs(onset["error [%]"])
    assert fine < 7.0 and coarse / fine > 2.5 and set(onset["ends by"]) == {"writhing"}


@pytest.mark.parametrize("model", ["network", "chain", "rod"])
def test_frequencies_are_those_of_the_rod(model):
    table = vibration_table(Sample(model=model), [25], 2)
    errors = np.array([table["lower error [%]"], table["upper error [%]"]])
    assert np.abs(errors).max() < 2.0 and (errors[0] <= errors[1]).all()


def test_the_rod_of_a_curl_runs_through_its_points():
    curl = Helix(radius=0.01, pitch=0.02)
    points = wound(curl, 0.1, 20)
    rod, clamp = helix.rod_of(Sample(), curl, points)
    np.testing.assert_allclose(hang_rod(rod, clamp).points[-1], points[-1], atol=1e-7)


def test_a_finely_divided_curl_is_as_stiff_as_the_rod():
    table = helix.helix_table(Sample(length=0.05), Helix(radius=0.02, pitch=0.02), [40], [1.0], 1)
    assert abs(table["stiffness error [%]"][0]) < 5 and abs(table["sag error [%]"][0]) < 5


@pytest.mark.parametrize(("curl", "length", "segments"), [((0.015, 0.03), 0.3, 25), ((0.004, 0.008), 0.133, 50)])
def test_a_coarse_curl_is_as_stiff_whichever_way_it_faces_and_is_wound(curl, length, segments):
    sample, points = Sample(length=length), wound(Helix(*curl), length, segments)
    stiff = helix.spring_of_rod(*helix.rod_of(sample, Helix(*curl), points))
    found = [helix.spring_of_strand(specimen_of(sample, points @ turn.T), turn[:, 2]) for turn in helix.turns(5)]
    np.testing.assert_allclose(found, found[0], rtol=1e-7)  # the stiffness is differenced
    assert found[0] == pytest.approx(stiff, rel=0.05)


def test_writhing_begins_from_the_stiffness_without_twist():
    way, onset = writhe_tables(Sample(), [10])
    assert way["twist / onset in theory"][0] == 0.0
    assert np.all(way["stiffness / that without twist"][1:] < 1.0)
    assert np.all(np.diff(way["twist / onset in theory"]) > 0)
    assert onset["strand [rad]"][0] == pytest.approx(way["twist / onset in theory"][-1] * onset["theory [rad]"][0])


@pytest.fixture(scope="module", params=["network", "rod"])
def specimen(request):
    return straight_specimen(Sample(model=request.param), 8)


def test_a_strand_at_rest_pulls_at_nothing(specimen):
    strongest = specimen.material.axial
    assert np.abs(forces(specimen, specimen.rest)).max() < 1e-12 * strongest


def test_stiffness_is_the_slope_of_the_forces_where_a_strand_is_in_equilibrium(specimen):
    free = motions(specimen)
    load = specimen.weight(np.array([0.0, 3.0, 1.0]))
    bent = balance(specimen, specimen.rest, load, free).pose
    way = free @ np.random.default_rng(5).normal(size=free.shape[1]) * 1e-6 * specimen.segment
    there, back = (forces(specimen, moved(specimen, bent, s * way.reshape(load.shape))) for s in (1, -1))
    change = free.T @ (there - back).reshape(-1) / 2
    expected = -free.T @ stiffness(specimen, bent) @ way
    np.testing.assert_allclose(change, expected, atol=1e-6 * np.abs(expected).max())


def test_moving_and_turning_as_a_whole_costs_nothing(specimen):
    matrix, x = stiffness(specimen, specimen.rest), specimen.rest.x
    for axis in np.eye(3):
        shifted, rotated = specimen.nothing(), specimen.nothing()
        shifted[:, :3], rotated[:, :3] = axis, np.cross(axis, x)
        rotated[:, 3:] = specimen.lever * axis[2]
        for way in (shifted, rotated / np.abs(rotated).max()):
            assert np.abs(matrix @ way.reshape(-1)).max() < 1e-9 * np.abs(matrix).max()


def test_under_a_small_load_it_moves_as_its_stiffness_says(specimen):
    load = specimen.nothing()
    load[specimen.tip, :3] = 1e-5 * specimen.material.bending / 0.3**2 * np.array([1.0, 2.0, 0.0])
    free = motions(specimen)
    matrix = free.T @ stiffness(specimen, specimen.rest) @ free
    way = 1e3 * (free @ np.linalg.solve(matrix, free.T @ load.reshape(-1))).reshape(load.shape)[specimen.tip, :3]
    found = balance(specimen, specimen.rest, 1e3 * load, free)
    assert found.found
    assert np.linalg.norm((found.pose.x - specimen.rest.x)[specimen.tip] - way) < 0.02 * np.linalg.norm(way)


def test_a_clamped_root_does_not_move_and_a_slide_moves_as_one(specimen):
    held = specimen.nothing()
    held[:3, :3] = 1.0
    held[:2] = 1.0
    assert not motions(specimen)[held.reshape(-1) > 0].any()
    sliding = motions(specimen, slides=True)
    end = sliding[:, -1].reshape(held.shape)
    assert not sliding[held.reshape(-1) > 0].any() and not end[:-3].any()
    np.testing.assert_array_equal(end[-3:, :3], [[0, 0, 1]] * 3)
    others = sliding[:, :-1].reshape(*held.shape, -1)
    assert others.any(axis=2)[3:-3].all() and not others[-3:].any()


def test_only_springs_of_a_network_are_guessed():
    with pytest.raises(BadInput, match="cannot be guessed"):
        specimen_of(Sample(model="rod", constants="guessed"), np.eye(3))


def test_the_theory_is_the_first_zero_of_a_bessel_function():
    assert brentq(lambda gamma: jv(-1 / 3, 2 / 3 * np.sqrt(gamma)), 4.0, 12.0) == pytest.approx(GREENHILL, abs=1e-6)


@pytest.mark.kernels
def test_a_rod_buckles_at_the_weight_of_greenhill():
    specimen = straight_specimen(Sample(model="rod"), 25)
    assert is_stable(specimen, 0.99 * GREENHILL) and not is_stable(specimen, 1.01 * GREENHILL)
    (row,) = column_table(Sample(model="rod"), [25]).rows()
    assert abs(row[-1]) < 0.5


def test_chords_are_equal_and_curvature_grows():
    rod = rod_of(ROD, Spiral())
    points, length = cut(rod, 0.006, 50)
    chords = np.diff(points, axis=0)
    np.testing.assert_allclose(np.linalg.norm(chords, axis=1), 0.006, rtol=1e-9)
    assert 0.3 < length < 0.302
    bends = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1) / 0.006**3
    expected = rod.natural_at(length * np.arange(1, 50) / 50)[1]
    np.testing.assert_allclose(bends, expected, rtol=0.02)


@pytest.mark.kernels
def test_errors_of_a_rod_fall_by_the_square_of_its_segments():
    table = spiral_table(ROD, Spiral(), [15, 30], [3.0], 1)
    assert table["no equilibrium"].tolist() == [0, 0]
    coarse, fine = table["error of the way [%]"]
    assert coarse / fine == pytest.approx(4.0, rel=0.1) and fine < 1.0


def test_a_way_without_an_equilibrium_is_missed(monkeypatch):
    monkeypatch.setattr(spiral, "balance", lambda specimen, pose, load, free: Balance(pose, 1.0))
    table = spiral_table(ROD, Spiral(), [15], [3.0], 1)
    assert table["no equilibrium"].tolist() == [2]
    (row,) = checked([table], ["rod"], "error of the way [%]", [1e9], [], ("way", "theory")).rows()
    assert Row(*row).verdict == "missed"


COUNT, TWIST = 8, 2.0


@pytest.mark.parametrize("model", ["rod", "network"])
def test_a_ring_is_closed_and_its_segments_keep_their_length(model):
    specimen = straight_specimen(Sample(model=model), COUNT)
    axis = ring.ringed(specimen, TWIST)[specimen.shape.axis]
    np.testing.assert_allclose(axis[-2:].mean(axis=0), axis[0], atol=1e-12)
    chord = 2 * np.sin(np.pi * specimen.segment / held_length(specimen)) * held_length(specimen) / (2 * np.pi)
    np.testing.assert_allclose(np.linalg.norm(np.diff(axis[:-2], axis=0), axis=1), chord, rtol=1e-12)


def test_a_twisted_ring_carries_the_torque_of_the_theory():
    def error(count: int) -> float:
        specimen = straight_specimen(Sample(model="rod"), count)
        pose = ring.twisted_on(specimen, ring.closed(specimen), 0.0, TWIST)
        at = balance(specimen, pose, specimen.nothing(), ring.ring_motions(specimen))
        torque = -forces(specimen, at.pose)[-specimen.shape.clamped, 3] * specimen.lever
        return abs(torque * held_length(specimen) / (specimen.material.torsion * TWIST) - 1)

    coarse, fine = error(COUNT), error(2 * COUNT)
    assert fine < 0.06 and coarse / fine > 3


def test_the_point_opposite_stays_in_the_plane():
    specimen = straight_specimen(Sample(model="rod"), COUNT)
    free = ring.ring_motions(specimen).reshape(*specimen.nothing().shape, -1)
    opposite = np.arange(len(free))[specimen.shape.axis][COUNT // 2]
    assert free[opposite].any(axis=1).tolist() == [True, False, True, True]


@pytest.mark.kernels
def test_a_ring_buckles_at_the_twist_of_michell():
    material = Sample().material
    assert ring.buckling_twist(material.bending, material.torsion) == pytest.approx(
        10.8828 * (1 + material.poisson), 1e-5
    )
    coarse, fine = (abs(row[4]) for row in ring.ring_table(Sample(model="rod"), [10, 20]).rows())
    assert fine < 10.0 and fine < coarse / 2


def test_fan_of_equal_strands_reports_the_largest_difference():
    one = lay_strands(1, 0.1, 4, (1.0, 0.5, 0.0), (0.0, 0.0, 0.0), None, 0.2)
    fan = fanned(one, 9, 0.01)
    strands = fan.points.reshape(9, 5, 3)
    np.testing.assert_allclose(np.diff(strands[0], axis=0), np.diff(one.points, axis=0), atol=1e-15)
    np.testing.assert_allclose(fan.root_frames[:, :, 3], strands[:, 0])
    np.testing.assert_allclose(np.linalg.norm(strands[:, 0], axis=1), 0.01)
    np.testing.assert_allclose(np.linalg.norm(strands[1, 1] - strands[0, 1]), 2 * np.sin(np.pi / 9) * strands[0, 1, 0])
    bent = fan.points.copy()
    bent[-1, 1] += 2e-3
    shot = {
        n: Strands(points, np.zeros_like(points, np.float32), fan.offsets, 8e-5)
        for n, points in ((5, fan.points), (17, bent))
    }
    table = fan_table(shot, 24.0)
    np.testing.assert_allclose(table["time [s]"], [0.0, 0.5])
    np.testing.assert_allclose(table["difference [% of length]"], [0.0, 2.0], atol=1e-12)
