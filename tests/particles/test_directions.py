"""Directions follow the links."""

import numpy as np
import pytest

from hairpipe.particles.links import redirect
from hairpipe.particles.model import build_model


def turned(model, points, directions):
    directions = directions.copy()
    redirect(
        model.links,
        model.reach,
        np.full(len(points), 0.1),
        model.deep,
        points,
        np.empty(len(model.links.ends)),
        directions,
    )
    return directions


def test_at_rest_they_stay_and_turned_with_all_the_hair_they_turn_with_it(particles):
    model, rng = build_model(particles), np.random.default_rng(4)
    directions = particles.directions + 0.2 * rng.normal(size=particles.directions.shape)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    same = turned(model, particles.points, particles.directions)
    assert same == pytest.approx(particles.directions, abs=1e-9)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    once = turned(model, particles.points, directions)
    both = turned(model, particles.points @ turn.T, directions @ turn.T)
    assert both[model.deep :] == pytest.approx((once @ turn.T)[model.deep :], abs=1e-9)


def test_sheared_hair_points_where_it_leads(particles):
    """x moves by half of how far down a particle is: so do directions, which are unit vectors."""
    model, shear = build_model(particles), np.array([[1.0, -0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    directions = particles.directions
    for _ in range(20):
        directions = turned(model, particles.points @ shear.T, directions)
    assert directions[model.deep :].mean(axis=0) == pytest.approx(np.array([0.5, -1.0, 0.0]) / np.sqrt(1.25), abs=0.06)


def test_hair_that_no_link_holds_keeps_its_direction(particles):
    model = build_model(particles)
    loose = model._replace(links=model.links._replace(strength=np.zeros_like(model.links.strength)))
    assert np.array_equal(turned(loose, particles.points, particles.directions), particles.directions)
