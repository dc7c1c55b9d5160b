"""Explicit steps go the way of implicit ones, up to a length that stiffness tells; links that fade are lost."""

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, eigsh

from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.settings import Interaction

FRAME = 1 / 24


def test_they_converge_to_the_motion_of_implicit_ones(shot):
    def swung(**settings):
        return shot(**settings).run(6, kick=lambda frame: np.array([0.5, 0.0, 0.2])).state.points

    truth = swung(printed=("steps",), steps=96)
    errors = [np.abs(swung(steps=n) - truth).max() for n in (6, 24, 96)]
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]


def fastest(hair):
    """The largest frequency [1/s] that links have at rest: of sum K d d^T / m."""
    model, axial = hair.prepared.model, hair.prepared.springs.axial
    links, points = model.links, hair.particles.points
    ways, stiffness = np.empty((len(links.ends), 4)), np.empty(len(links.ends))
    measure_links(links, points, ways)
    stiffen(links, model.reach, axial, ways, stiffness)
    free = np.arange(len(points)) >= model.deep

    def times(x):
        x = x.reshape(-1, 3) * free[:, None]
        force = (stiffness * np.sum(ways[:, :3] * (x[links.ends[:, 1]] - x[links.ends[:, 0]]), axis=1))[:, None]
        total = np.zeros_like(x)
        np.add.at(total, links.ends[:, 1], force * ways[:, :3])
        np.add.at(total, links.ends[:, 0], -force * ways[:, :3])
        return (total * free[:, None] / model.masses[0]).ravel()

    size = 3 * len(points)
    return float(
        np.sqrt(eigsh(LinearOperator((size, size), matvec=times, dtype=float), k=1, return_eigenvectors=False)[0])
    )


@pytest.mark.parametrize("sag", [0.1, 0.01])
def test_they_explode_where_they_are_longer_than_links_allow(shot, sag):
    """2 / omega, by the theory of symplectic steps; a hundred times the modulus needs ten times as many."""
    needed = fastest(shot(sag=sag)) * FRAME / 2.0
    kick = {"kick": lambda frame: np.array([0.01, 0.0, 0.0]) * (frame == 0)}
    enough = shot(sag=sag, damping=0.0, printed=("steps",), steps=round(1.3 * needed)).run(24, **kick)
    assert enough.pace < 1.0
    with pytest.raises(ArithmeticError, match="particles are not finite, among them on strands"):
        shot(sag=sag, damping=0.0, printed=("steps",), steps=round(0.6 * needed)).run(96, **kick)


def test_hair_pulled_off_is_lost_where_all_links_fade(shot):
    def pulled(**settings):
        hair = shot(interaction=Interaction(), **settings)
        side = np.where(hair.particles.points[:, 0] > 0.0, 40.0, -40.0) * (hair.particles.arcs >= 0.0)
        hair.run(24, kick=lambda frame: np.outer(side, (FRAME, 0.0, 0.0)))
        return hair.run(72)

    kept, lost = pulled(), pulled(printed=("links",))
    assert kept.out < 0.05 and kept.pace < 5e-3
    assert lost.out > 0.1 and lost.pace > 1.0
