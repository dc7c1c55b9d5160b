"""A strand that is closed to a ring buckles at the twist of Michell."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.accuracy.ring import (
    buckling_twist,
    closed,
    ring_motions,
    ring_table,
    ringed,
    twisted_on,
)
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import forces, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import balance
from hairpipe.graphs.experiments.studies.accuracy.torsion import held_length

COUNT, TWIST = 8, 2.0


@pytest.mark.parametrize("model", ["rod", "network"])
def test_a_ring_is_closed_and_its_segments_keep_their_length(model):
    specimen = straight_specimen(Sample(model=model), COUNT)
    axis = ringed(specimen, TWIST)[specimen.shape.axis]
    np.testing.assert_allclose(axis[-2:].mean(axis=0), axis[0], atol=1e-12)
    chord = 2 * np.sin(np.pi * specimen.segment / held_length(specimen)) * held_length(specimen) / (2 * np.pi)
    np.testing.assert_allclose(np.linalg.norm(np.diff(axis[:-2], axis=0), axis=1), chord, rtol=1e-12)


def test_a_twisted_ring_carries_the_torque_of_the_theory():
    def error(count: int) -> float:
        specimen = straight_specimen(Sample(model="rod"), count)
        pose = twisted_on(specimen, closed(specimen), 0.0, TWIST)
        at = balance(specimen, pose, specimen.nothing(), ring_motions(specimen))
        torque = -forces(specimen, at.pose)[-specimen.shape.clamped, 3] * specimen.lever
        return abs(torque * held_length(specimen) / (specimen.material.torsion * TWIST) - 1)

    coarse, fine = error(COUNT), error(2 * COUNT)
    assert fine < 0.06 and coarse / fine > 3


def test_the_point_opposite_stays_in_the_plane():
    specimen = straight_specimen(Sample(model="rod"), COUNT)
    free = ring_motions(specimen).reshape(*specimen.nothing().shape, -1)
    opposite = np.arange(len(free))[specimen.shape.axis][COUNT // 2]
    assert free[opposite].any(axis=1).tolist() == [True, False, True, True]


@pytest.mark.kernels
def test_a_rod_buckles_at_it():
    material = Sample().material
    assert buckling_twist(material.bending, material.torsion) == pytest.approx(10.8828 * (1 + material.poisson), 1e-5)
    coarse, fine = (abs(row[4]) for row in ring_table(Sample(model="rod"), [10, 20]).rows())
    assert fine < 10.0 and fine < coarse / 2
