"""The energy of a strand is that of which the kernels' forces are the gradient."""

import numpy as np
import pytest
from numba import njit

from hairpipe.graphs.experiments.studies.contact.bar import tuft
from hairpipe.graphs.experiments.studies.integrators.energy import altitude_energies, energies
from hairpipe.solve.band import row_size
from hairpipe.solve.stage import Iterate, State, System
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.interface import Terms, add_forces
from hairpipe.strands.material import Material


@njit
def add_all(model, A, b, x, still):
    for p in range(x.shape[0]):
        add_forces(model, System(A, b), Iterate(x, still, still), p, 0, Terms(1.0, 0.0, 0.0, 0))


@pytest.mark.parametrize("seed", range(3))
def test_force_of_a_network_is_minus_the_gradient_of_its_springs_and_altitudes(seed):
    """Bent at random, so far that no choice of an altitude changes hands on the way."""
    hair = build_hair(tuft(), Material(), "network")
    model, rng, count = hair.model, np.random.default_rng(seed), int(hair.model.first[1])
    place = hair.rest + 3e-4 * rng.normal(size=hair.rest.shape)
    still, way = np.zeros_like(place[:count]), np.zeros_like(place)
    way[:count] = 1e-9 * rng.normal(size=still.shape)

    def energy(x):
        state = State(x, np.zeros_like(x), np.zeros_like(x), np.zeros_like(model.inverse_lengths), np.zeros(1, bool))
        return (energies(hair, state, 0.0) + altitude_energies(model, hair.layout, x))[0]

    force = np.zeros_like(still)
    add_all(model, np.zeros((count, row_size(model.shape), still.shape[2])), force, place[:count].copy(), still)
    done = 2.0 * np.einsum("pcl,pcl->l", force, way[:count])
    assert energy(place - way) - energy(place + way) == pytest.approx(done, rel=1e-4, abs=1e-5 * np.abs(done).max())
