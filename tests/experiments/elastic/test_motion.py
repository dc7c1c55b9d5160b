"""How bodies of springs move, recover, and what shape they have."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.elastic import mesh_geometry
from hairpipe.graphs.experiments.elastic.elastic_frame import advance_frame, begin
from hairpipe.graphs.experiments.elastic.elastic_settings import ElasticScene, Ground, Stir
from hairpipe.graphs.experiments.elastic.elastic_values import Solid
from hairpipe.graphs.experiments.elastic.hinges import boundary, hinges
from hairpipe.graphs.experiments.elastic.matter import Fabric, Rubber
from hairpipe.graphs.experiments.elastic.sheets import build_cloth, build_noodle
from hairpipe.graphs.experiments.elastic.spring_mesh import shell_springs, solid_springs
from hairpipe.graphs.experiments.elastic.squash import squash
from hairpipe.graphs.experiments.elastic.torus import build_torus
from hairpipe.graphs.experiments.measure.elastic_measures import measure_angles, measure_volume


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


TORUS = build_torus(0.5, 0.2, 1, 16, 0.3)


def relax(altitudes, shape, frames=60, seed=1):
    rubber = Rubber(2e5, damping=0.02, altitudes=altitudes)
    springs, scene = solid_springs(TORUS, rubber), ElasticScene(0.0, steps=10)
    state = begin(springs, squash(TORUS, shape, seed).points, scene)
    for _ in range(frames):
        state = advance_frame(springs, state, 1 / 24, scene, rubber.damping)
    volume, rest = (mesh_geometry.volumes(x, TORUS.tetrahedra) for x in (state.positions, TORUS.points))
    return volume.sum() / rest.sum(), int(np.sum(volume <= 0))


@pytest.mark.parametrize("shape", ["plane", "line", "slanted_line", "mirrored"])
def test_altitude_springs_bring_every_shape_back(shape):
    volume, inverted = relax("selected", shape)
    assert volume == pytest.approx(1.0, abs=1e-3) and inverted == 0


@pytest.mark.parametrize("shape", ["scrambled", "scrambled_line"])
@pytest.mark.parametrize("seed", [1, 2])
def test_altitude_springs_turn_every_tetrahedron_upright(shape, seed):
    """A ring that may pass through itself is, from some places, wound twice and then keeps 96 % of its volume."""
    volume, inverted = relax("selected", shape, seed=seed)
    assert volume > 0.95 and inverted == 0


@pytest.mark.parametrize("shape", ["plane", "line", "mirrored"])
def test_edges_alone_do_not(shape):
    volume, inverted = relax("none", shape, frames=20)
    assert volume < 1e-6 and inverted > len(TORUS.tetrahedra) / 2


@pytest.mark.parametrize(("shape", "most"), [("line", 1e-6), ("scrambled", 0.9)])
def test_altitude_springs_of_2003_lock(shape, most):
    assert relax("faces", shape)[0] < most


def test_particles_in_one_point_have_nowhere_to_go():
    assert relax("selected", "point", frames=2) == (0.0, len(TORUS.tetrahedra))


@pytest.mark.parametrize(("altitudes", "recovers"), [("selected", True), ("none", False)])
def test_torus_rises_from_its_puddle(altitudes, recovers):
    torus = build_torus(0.5, 0.2, 1, 16, 0.3)
    rubber = Rubber(2e5, damping=0.05, altitudes=altitudes)
    springs = solid_springs(torus, rubber)
    scene = ElasticScene(slack=0.5, steps=10, ground=Ground(), stir=Stir(0.3))
    states = [begin(springs, torus.points, scene)]
    for _ in range(60):
        states.append(advance_frame(springs, states[-1], 1 / 24, scene, rubber.damping))
    table = measure_volume(torus, states)
    assert table["volume [%]"][12] < 0.1, "a puddle"
    assert (table["volume [%]"][-1] > 98 and table["inverted"][-1] == 0) == recovers
    if not recovers:
        assert table["top [m]"][-1] == 0.0


def test_noodle_bends_back_from_flat():
    noodle, fabric = build_noodle(0.5, 0.15, 12, 8, 0.0), Fabric()
    springs, scene = shell_springs(noodle, fabric), ElasticScene(steps=10, ground=Ground())
    state = begin(springs, noodle.points * [1, 0, 1], scene)
    states = [state]
    for _ in range(24):
        states.append(advance_frame(springs, states[-1], 1 / 24, scene, fabric.damping))
    errors = measure_angles(noodle, states)["RMS angle error [deg]"]
    assert errors[0] > 40 and errors[-1] < 5
    assert np.abs(mesh_geometry.angles(states[0].positions, hinges(noodle.triangles)) % np.pi).max() < 1e-9, "flat"


def test_cloth_runs_at_one_step_per_frame():
    """Its energy only falls, and it swings as with small steps: within 5 % of its length over the first second."""
    cloth, fabric = build_cloth(1.0, 8, 2.0), Fabric(2e6, 0.5e-3, 400.0, 5e-3)
    springs = shell_springs(cloth, fabric)

    def swing(steps, frames=48):
        scene = ElasticScene(drag=0.5, steps=steps)
        states = [begin(springs, cloth.points, scene)]
        for _ in range(frames):
            states.append(advance_frame(springs, states[-1], 1 / 24, scene, fabric.damping))
        return measure_angles(cloth, states)

    coarse, fine = swing(1), swing(10)
    assert np.all(np.diff(coarse["energy [J]"]) < 1e-6)
    np.testing.assert_allclose(coarse["z [m]"], fine["z [m]"], atol=0.05)
    assert np.ptp(fine["z [m]"]) > 0.8


def directed(triangles):
    return {(a, b) for t in triangles.tolist() for a, b in zip(t, t[1:] + t[:1], strict=True)}


def test_torus_is_filled_with_upright_tetrahedra():
    solid = build_torus(0.5, 0.2, 3, 40, 1.6)
    volume = mesh_geometry.volumes(solid.points, solid.tetrahedra)
    assert volume.min() > 0 and 1.6 <= solid.points[:, 1].min() < 1.605
    exact = 2 * np.pi**2 * 0.5 * 0.2**2
    polygon = 6 * 3 * np.sin(2 * np.pi / 18) / 2 * 2 / (2 * np.pi)
    assert abs(volume.sum() / exact - polygon) < 0.01


def test_surface_of_the_torus_is_closed_and_looks_outward():
    solid = build_torus(0.5, 0.2, 2, 24, 0.0)
    surface = boundary(solid.tetrahedra)
    edges = directed(surface)
    assert len(edges) == 3 * len(surface) and edges == {(b, a) for a, b in edges}
    assert len(set(surface.ravel())) - len(edges) // 2 + len(surface) == 0, "a torus has Euler characteristic 0"
    a, b, c = (solid.points[surface[:, i]] for i in range(3))
    inside = np.sum(np.cross(b, c) * a) / 6
    np.testing.assert_allclose(inside, mesh_geometry.volumes(solid.points, solid.tetrahedra).sum(), rtol=1e-12)


def test_shells_are_turned_one_way():
    for shell in (build_noodle(0.5, 0.15, 8, 6, 1.0), build_cloth(1.0, 5, 1.0)):
        assert len(directed(shell.triangles)) == 3 * len(shell.triangles)


def test_hinges_are_the_inner_edges():
    cloth = build_cloth(1.0, 6, 1.0)
    fours = hinges(cloth.triangles)
    assert len(fours) == 2 * 6 * 5 + 6 * 6
    triangles = {frozenset(t) for t in cloth.triangles.tolist()}
    assert {frozenset(f[[0, 1, 2]].tolist()) for f in fours} | {
        frozenset(f[[0, 1, 3]].tolist()) for f in fours
    } == triangles
    assert cloth.pinned.sum() == 2


def test_angles_of_a_tube_are_those_of_its_polygon():
    noodle = build_noodle(50.0, 0.15, 400, 12, 0.0)
    bent = np.degrees(mesh_geometry.angles(noodle.points, hinges(noodle.triangles)))
    bent = np.abs(bent)[np.abs(bent) > 20]
    np.testing.assert_allclose(bent, 30.0, atol=0.5)
    assert len(bent) == 400 * 12


def test_altitudes_of_a_regular_tetrahedron():
    points = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    heights = mesh_geometry.altitudes(points, np.array([[0, 1, 2, 3]]))[0]
    np.testing.assert_allclose(np.abs(heights), [4 / np.sqrt(3)] * 4 + [2.0] * 3)
    assert len(set(np.sign(heights))) == 1
    np.testing.assert_allclose(np.abs(mesh_geometry.volumes(points, np.array([[0, 1, 2, 3]]))), 8 / 3)
