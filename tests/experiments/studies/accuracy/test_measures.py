"""What the experiments measure, where the answer is known."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.accuracy.cantilever import cantilever_table
from hairpipe.graphs.experiments.studies.accuracy.helix import (
    helix_table,
    rod_of,
    spring_of_rod,
    spring_of_strand,
    turns,
)
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import specimen_of
from hairpipe.graphs.experiments.studies.accuracy.torsion import torsion_table
from hairpipe.graphs.experiments.studies.accuracy.vibration import vibration_table
from hairpipe.graphs.experiments.studies.accuracy.writhe import writhe_tables
from hairpipe.graphs.experiments.studies.theory.clamps import hang_rod

GUESSED, ROD = Sample(constants="guessed"), Sample(model="rod")


def test_a_calibrated_strand_sags_as_the_elastica_and_a_guessed_one_does_not():
    calibrated = cantilever_table(Sample(), [12], [0.0, 90.0], 2, [1.0, 2.0])
    guessed = cantilever_table(GUESSED, [12], [90.0], 1, [1.0])
    assert not calibrated["no equilibrium"].any()
    assert max(calibrated["tip error [% of length]"]) < 1.0 < guessed["tip error [% of length]"][0]


def test_a_chain_is_not_twisted():
    with pytest.raises(BadInput, match="cannot be twisted"):
        torsion_table(Sample(model="chain"), [5], [1.0])


def test_torque_is_that_of_the_rod_and_both_senses_are_tried():
    table = torsion_table(Sample(), [20], [0.05])
    np.testing.assert_allclose(table["twist [rad]"], [-0.05, 0.05])
    np.testing.assert_allclose(table["torque error [%]"], 0.0, atol=1.0)
    assert (table["tip shift [% of length per rad]"] < 2.0).all()  # of a rod it is nothing
    assert abs(torsion_table(GUESSED, [20], [0.05])["torque error [%]"][0]) > 10


def test_a_straight_rod_has_its_torque_exactly_and_its_tip_stays():
    table = torsion_table(ROD, [8], [0.5, 4.0])
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
    rod, clamp = rod_of(Sample(), curl, points)
    np.testing.assert_allclose(hang_rod(rod, clamp).points[-1], points[-1], atol=1e-7)


def test_a_finely_divided_curl_is_as_stiff_as_the_rod():
    table = helix_table(Sample(length=0.05), Helix(radius=0.02, pitch=0.02), [40], [1.0], 1)
    assert abs(table["stiffness error [%]"][0]) < 5 and abs(table["sag error [%]"][0]) < 5


@pytest.mark.parametrize(("curl", "length", "segments"), [((0.015, 0.03), 0.3, 25), ((0.004, 0.008), 0.133, 50)])
def test_a_coarse_curl_is_as_stiff_whichever_way_it_faces_and_is_wound(curl, length, segments):
    sample, points = Sample(length=length), wound(Helix(*curl), length, segments)
    stiff = spring_of_rod(*rod_of(sample, Helix(*curl), points))
    found = [spring_of_strand(specimen_of(sample, points @ turn.T), turn[:, 2]) for turn in turns(5)]
    np.testing.assert_allclose(found, found[0], rtol=1e-7)  # the stiffness is differenced
    assert found[0] == pytest.approx(stiff, rel=0.05)


def test_writhing_begins_from_the_stiffness_without_twist():
    way, onset = writhe_tables(Sample(), [10])
    assert way["twist / onset in theory"][0] == 0.0
    assert np.all(way["stiffness / that without twist"][1:] < 1.0)
    assert np.all(np.diff(way["twist / onset in theory"]) > 0)
    assert onset["strand [rad]"][0] == pytest.approx(way["twist / onset in theory"][-1] * onset["theory [rad]"][0])
