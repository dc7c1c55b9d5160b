"""The calibrated network is the rod it stands for."""

import numpy as np
import pytest

from hairpipe.sim import calibration, lattice
from hairpipe.sim.material import Material


def test_stiffness_agrees_with_the_closed_form_at_right_angles(monkeypatch):
    """Compliances of springs in series: 1/EI = (2/k_e + 4 sqrt3/k_t)/l^2 and so on (prototype.md 2)."""
    monkeypatch.setattr(lattice, "TURN", np.pi / 2)
    edge, bending, torsion = 50.0, 7.0, 5.0
    bend = 1 / (2 / edge + 4 * np.sqrt(3) / torsion)
    twist = 1 / (44 / 9 / edge + 16 / 9 * 2.5**1.5 / bending + 8 / np.sqrt(3) / torsion)
    stiffness = calibration.rod_stiffness(np.array([edge, bending, torsion, 0.0]))
    np.testing.assert_allclose(stiffness, [bend, twist], rtol=1e-9)


@pytest.mark.parametrize("poisson", [0.0, 0.35, 0.5])
@pytest.mark.parametrize("length", [0.002, 0.01])
def test_network_has_the_stiffness_of_the_material(poisson, length):
    material = Material(poisson=poisson)
    constants = calibration.spring_constants(material, np.array([length, 2 * length]))[:, 0]
    stiffness = calibration.rod_stiffness(constants) * length**2
    np.testing.assert_allclose(stiffness, [material.bending, material.torsion], rtol=1e-6)


def test_constants_between_the_fitted_lengths_are_within_a_thousandth():
    material = Material()
    lengths = np.array([0.002, 0.005, 0.012])
    constants = calibration.spring_constants(material, lengths)[:, 1]
    stiffness = calibration.rod_stiffness(constants) * lengths[1] ** 2
    np.testing.assert_allclose(stiffness, [material.bending, material.torsion], rtol=1e-3)
