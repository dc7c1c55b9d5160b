"""Rods of 25 segments at rest against independent theory: the elastica, and Kirchhoff's rod."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.accuracy.helix import rod_of, spring_of_rod, turns
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.theory.clamps import hang_rod
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.solve.sag_free import assemble
from hairpipe.solve.settle import settle
from hairpipe.strands.interface import StiffnessPart
from hairpipe.strands.material import Material

LENGTH, CURL = 0.3, Helix(radius=0.015, pitch=0.03)
"""Three turns, of 8.2 segments each."""


@pytest.fixture
def rods(scene):
    return lambda *strands: scene(strands, model="rod").hair


def hung(hair, gravity):
    """Where the tips come to rest [m], (strands, 3)."""
    everyone = np.ones(hair.layout.strands.shape, bool)
    found = settle(hair.model, hair.layout, hair.groom.ids, hair.rest, np.asarray(gravity, float), everyone)
    return hair.layout.axis(found.positions)[hair.groom.offsets[1:] - 1]


@pytest.mark.parametrize(("angle", "most"), [(90, 0.2), (45, 0.15), (135, 0.8)])
@pytest.mark.parametrize("gamma", [1.0, 10.0, 100.0])
def test_cantilevers_sag_like_the_elastica(rods, straight, angle, most, gamma):
    """The error in % of the length; the angle is that from hanging."""
    turn, material, length = np.deg2rad(angle), Material(softening=1.0), 0.1
    strand = straight(length, 25, [np.sin(turn), -np.cos(turn), 0])
    gravity = gamma * material.bending / (material.line_density * length**3)
    tip = (hung(rods(strand), [0, -gravity, 0])[0] - strand[0]) / length
    assert np.linalg.norm(tip[:2] - bend_elastica(gamma, turn - np.pi / 2).tip) < most / 100
    assert abs(tip[2]) < 1e-9


@pytest.fixture(scope="module")
def helix():
    points = wound(CURL, LENGTH, 25)
    return points, *rod_of(Sample(length=LENGTH), CURL, points)


def test_a_curl_sags_like_kirchhoffs_rod_and_alike_in_every_orientation(rods, helix):
    points, rod, clamp = helix
    weight = np.array([0.0, 0.0, Material().line_density * 9.81])
    theory = hang_rod(replace(rod, weight=weight), clamp).points[-1, 2] - points[-1, 2]
    sags = [
        (hung(rods(points @ turn.T), 9.81 * turn[:, 2])[0] - turn @ points[-1]) @ turn[:, 2] / theory
        for turn in turns(3)
    ]
    np.testing.assert_allclose(sags, sags[0], rtol=1e-6)
    assert abs(sags[0] - 1) < 0.04


def test_a_curl_is_as_stiff_as_kirchhoffs_rod(rods, helix):
    """The second derivatives themselves, inverted for a pull at the tip along the axis."""
    points, rod, clamp = helix
    hair = rods(points)
    A, _ = assemble(hair.model, 0, hair.rest, np.zeros_like(hair.model.inverse_lengths), int(StiffnessPart.exact))
    nodes = A[1:-1, :, 0]
    size = 4 * len(nodes)
    dense = np.zeros((size + 12, size + 12))
    for p, row in enumerate(nodes):
        for j, place in enumerate((0, 11, 21, 30)):
            dense[4 * p + j, 4 * p + j : 4 * p + 11] = row[place : place + 11 - j]
    pull, tip = np.zeros(size), size - 2
    pull[tip] = 1.0
    free = slice(7, size)  # from the angle of the first edge on
    way = np.linalg.solve((dense + np.triu(dense, 1).T)[free, free], pull[free])[tip - 7]
    assert abs(1 / way / spring_of_rod(rod, clamp) - 1) < 0.01
