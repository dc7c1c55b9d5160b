"""Strands that fall across others come to rest on them, at any step."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.geometry.proximity import near_pairs
from hairpipe.laws.settings import Collisions, Thickness

LAW = Collisions()


@pytest.fixture
def pile(scene, triangle):
    """Give four strands side by side and twelve across them, each 0.4 mm above the one before."""

    def make(step):
        base, rng = triangle().points.mean(0), np.random.default_rng(0)
        strands = [base + [0, 0, 0.004 * k] + np.linspace(0, 0.03, 11)[:, None] * [1, 0, 0] for k in range(4)]
        for k in range(12):
            aside = 0.004 + 0.004 * (k % 5) + rng.uniform(-1e-4, 1e-4)
            place = base + np.array([aside, 0.0006 + 0.0004 * k, -0.02])
            strands.append(place + np.linspace(0, 0.05, 17)[:, None] * [0, 0, 1])
        shot = scene(strands, step=step, drag=2.0)
        shot.scene = replace(shot.scene, collisions=LAW)
        return shot

    return make


def heights_over(shot):
    """How far strands are above the others where they cross, seen from above [m]."""
    x, offsets = shot.axis, shot.hair.layout.offsets
    under, over = (
        np.concatenate([np.arange(offsets[s], offsets[s + 1] - 1) for s in r]) for r in (range(4), range(4, 16))
    )
    i, j = (part.ravel() for part in np.meshgrid(under, over, indexing="ij"))
    a, c, r = x[i + 1] - x[i], x[j + 1] - x[j], x[j] - x[i]
    area = a[:, 0] * c[:, 2] - a[:, 2] * c[:, 0]
    s, t = (r[:, 0] * c[:, 2] - r[:, 2] * c[:, 0]) / area, (r[:, 0] * a[:, 2] - r[:, 2] * a[:, 0]) / area
    cross = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return (r + t[:, None] * c - s[:, None] * a)[cross, 1]


def test_crossing_hairs_rest_with_the_coupled_solver_and_not_with_the_published_one(scene):
    """A hair of 45 mm falls across one of 30 mm without friction: what `warn_of_sweep` warns of."""
    along, end = np.linspace(0.0, 1.0, 25)[:, None], {}
    over, under = along * [0.045, 0.0, 0.0], [0.03, -2e-3, -0.02] + along * [0.0, 0.0, 0.03]
    for solver in ("coupled", "sweep"):
        shot = scene([over, under], step=1 / 48, drag=0.5)
        shot.scene = replace(shot.scene, collisions=Collisions(Thickness(1e-3), friction=0.0, solver=solver))
        end[solver] = np.abs(shot.run(2.0).state.velocities).max()
    assert end["coupled"] < 0.01 and end["sweep"] > 5.0 * end["coupled"]


@pytest.mark.parametrize("step", [1 / 60, 1 / 240])
def test_pile_comes_to_rest(pile, step):
    shot, fastest = pile(step), []
    for _ in range(16):
        shot.run(1 / 24)
        fastest.append(np.abs(shot.state.velocities).max())
    assert max(fastest) < 1.0 and max(fastest[-3:]) < 0.3
    heights = heights_over(shot)
    assert len(heights) > 30 and (heights > 0.5 * LAW.thickness.value).all()
    near = near_pairs(shot.axis, shot.hair.layout.offsets, LAW.thickness.value)
    assert len(near.distances) > 5 and near.distances.min() > 0.5 * LAW.thickness.value
