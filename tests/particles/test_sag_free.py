"""Links that are shortened carry the hair."""

import numpy as np
import pytest

from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.model import build_model
from hairpipe.particles.simulate import rest_lengths


def test_link_tensions_balance_gravity(particles):
    """But for the softness that was added, and what could not be had within the strain."""
    model, points = build_model(particles), particles.points
    axial = np.full(len(points), 9.81 * model.hang / 0.1)
    rest = rest_lengths(model, points, axial, 9.81, 0.9)
    ways, stiffness = np.empty((len(rest), 4)), np.empty(len(rest))
    measure_links(model.links, points, ways)
    stiffen(model.links, model.reach, axial, ways, stiffness)
    tensions, force = stiffness * (ways[:, 3] - rest), np.zeros_like(points)
    np.add.at(force, model.links.ends[:, 0], tensions[:, None] * ways[:, :3])
    np.add.at(force, model.links.ends[:, 1], -tensions[:, None] * ways[:, :3])
    weight = 9.81 * model.masses[:, None] * (0.0, 1.0, 0.0)
    off = np.linalg.norm((force - weight)[model.deep :], axis=1) / weight[0, 1]
    assert np.median(off) < 0.02 and off.mean() < 0.05


def test_no_length_changes_by_more_than_is_allowed(particles):
    model = build_model(particles)
    axial = np.full(len(particles.points), 0.1 * 9.81 * model.hang)
    rest = rest_lengths(model, particles.points, axial, 9.81, 0.3)
    assert np.abs(rest / model.links.lengths - 1.0).max() == pytest.approx(0.3)
