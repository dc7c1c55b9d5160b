"""How bodies of springs move: order, ground, friction."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.elastic.elastic_frame import advance_frame, begin
from hairpipe.graphs.experiments.elastic.elastic_settings import ElasticScene, Ground, Stir
from hairpipe.graphs.experiments.elastic.elastic_values import Solid
from hairpipe.graphs.experiments.elastic.matter import Rubber
from hairpipe.graphs.experiments.elastic.spring_mesh import solid_springs


def run(springs, points, frames, scene, damping=0.0, velocity=0.0, fps=24.0):
    state = begin(springs, points, scene)
    state.velocities[:] += velocity
    for _ in range(frames):
        state = advance_frame(springs, state, 1 / fps, scene, damping)
    return state


@pytest.mark.parametrize(("scheme", "order"), [("backward_euler", 1), ("tr_bdf2", 2)])
def test_order_of_a_ringing_block(block, scheme, order):
    """The linear springs alone: where altitudes tie at rest the choice jumps, and no scheme has an order there."""
    springs = solid_springs(block, Rubber(100.0, 1.0, altitudes="none"))
    moved = block.points * [1.02, 0.99, 1.0]

    def end(steps):
        return run(springs, moved, 4, ElasticScene(0.0, steps=steps, scheme=scheme)).positions

    exact = run(springs, moved, 4, ElasticScene(0.0, steps=1280)).positions
    errors = [np.abs(end(steps) - exact).max() for steps in (20, 40, 80)]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert slopes[-1] == pytest.approx(order, abs=0.25)


def test_free_fall_is_exact(block):
    springs = solid_springs(block, Rubber(100.0, 1.0))
    state = run(springs, block.points, 24, ElasticScene(9.81, steps=1), velocity=np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(state.positions, block.points + np.array([0, 1 - 9.81 / 2, 0]), atol=1e-6)


def test_ground_carries_the_weight(block):
    springs = solid_springs(block, Rubber(1e5, 100.0))
    state = run(springs, block.points, 24, ElasticScene(steps=4, ground=Ground()), damping=0.1)
    assert state.positions[:, 1].min() == 0.0
    assert state.pressed.sum() == pytest.approx(9.81 * springs.mass.sum(), rel=1e-2)
    assert np.abs(state.velocities).max() < 1e-3


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5])
def test_friction_stops_a_sliding_block_after_its_due_way(block, friction):
    """Way in half a second at 3 m/s: v t - mu g t^2 / 2, or v^2 / (2 mu g) where it has stopped by then."""
    springs = solid_springs(block, Rubber(1e6, 100.0))
    scene = ElasticScene(steps=20, ground=Ground(friction))
    resting = run(springs, block.points, 24, scene, damping=0.1)
    resting.velocities[:] += [3.0, 0.0, 0.0]
    state = resting
    for _ in range(12):
        state = advance_frame(springs, state, 1 / 24, scene, 0.1)
    way = (state.positions - resting.positions)[:, 0].mean()
    time = min(0.5, 3 / (friction * 9.81 + 1e-9))
    assert way == pytest.approx(3 * time - friction * 9.81 * time**2 / 2, rel=0.05)


@pytest.mark.parametrize("scheme", ["backward_euler", "tr_bdf2"])
def test_impact_on_the_ground_loses_friction_times_its_momentum(scheme):
    """A lone particle, no weight: mu m v_n is all that friction takes."""
    scene = ElasticScene(0.0, steps=100, ground=Ground(0.1), scheme=scheme)
    alone = Solid(
        np.array([[0.0, 1e-4, 0.0], [0.0, 9.0, 0.0], [1.0, 9.0, 0.0], [0.0, 9.0, 1.0]]), np.array([[0, 2, 1, 3]])
    )
    springs = solid_springs(alone, Rubber(1e-9, 1.0))
    state = run(springs, alone.points, 1, scene, velocity=np.array([3.0, -1.0, 0.0]))
    np.testing.assert_allclose(state.velocities[0], [2.9, 0.0, 0.0], rtol=5e-3, atol=1e-6)


def test_springs_that_begin_to_act_do_all_their_work(block):
    """A stretched block, slack for a frame: it then moves as one that was let go of by then, to second order."""
    springs, moved = solid_springs(block, Rubber(100.0, 1.0, altitudes="none")), block.points * [1.02, 0.99, 1.0]

    def end(frames, slack, steps):
        return run(springs, moved, frames, ElasticScene(0.0, steps=steps, slack=slack)).positions

    exact = end(1, 0.0, 640)
    assert np.abs(exact - moved).max() > 1e-3
    errors = [np.abs(end(2, 1 / 24, steps) - exact).max() for steps in (20, 40)]
    assert errors[0] < 0.01 * np.abs(exact - moved).max() and errors[1] < 0.4 * errors[0]


def test_energy_of_slack_springs_is_not_counted(block):
    springs = solid_springs(block, Rubber(100.0, 1.0))
    state = run(springs, 1.1 * block.points, 1, ElasticScene(0.0, slack=1.0))
    assert state.energy[1] == 0.0


def test_pinned_particles_stay(block):
    springs = solid_springs(block, Rubber(1e4, 1.0))
    springs.free[:9] = 0.0
    state = run(springs, block.points, 12, ElasticScene(steps=2))
    np.testing.assert_allclose(state.positions[:9], block.points[:9], atol=1e-13)
    assert np.abs(state.positions[9:] - block.points[9:]).max() > 1e-4


def test_the_same_seed_stirs_alike(block):
    springs = solid_springs(block, Rubber())
    first, again, other = (
        begin(springs, block.points, ElasticScene(stir=Stir(0.3, seed))).velocities for seed in (1, 1, 2)
    )
    assert np.array_equal(first, again) and not np.array_equal(first, other)
    assert first.std() == pytest.approx(0.3, rel=0.2)


def test_non_finite_points_are_named(block):
    springs = solid_springs(block, Rubber())
    points = block.points.copy()
    points[7] = np.nan
    with pytest.raises(BadInput, match="particle 7 and 0 more diverged"):
        run(springs, points, 1, ElasticScene(steps=1))
