"""Hair carried by particles: rigid motion is exact, lengths stay, and it bends as the particles beside it do."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import root_frames
from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands
from hairpipe.laws.settings import Wind
from hairpipe.levelset.bake import bake
from hairpipe.nodes.carry_strands import carry_strands
from hairpipe.nodes.sample_particles import sample_particles
from hairpipe.nodes.simulate_particles import prepare_particles, simulate_particles
from hairpipe.particles.settings import Interaction
from hairpipe.particles.skinning import INFLUENCES, find_influences
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.values import Cloud, Groom, Mesh, Particles
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take

from .conftest import plate

SKIN = Mesh(np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, -0.1]]), np.array([[0, 1, 2]], np.int32))


def tuft(segments: int, stray: float = 10.0) -> Groom:
    """Twelve hairs of 10 cm that hang from a triangle."""
    row = lay_strands(4, 0.1, segments, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0)
    groom = gather_tuft(row, Tuft(rows=3, apart=(0.0, 0.0, 0.01), stray=stray))
    return replace(groom, root_frames=root_frames(*SKIN_SITE, groom.root_triangles, groom.root_barycentrics))


SKIN_SITE = SKIN.points, SKIN.triangles


def particles_on(groom: Groom) -> Particles:
    """A particle on every vertex of a groom, linked to those nearest."""
    strands = np.repeat(np.arange(len(groom.ids), dtype=np.int32), np.diff(groom.offsets))
    ways = np.diff(groom.points, axis=0, append=groom.points[-1:])
    ways[groom.offsets[1:] - 1] = ways[groom.offsets[1:] - 2]
    lengths = np.linalg.norm(ways, axis=1)
    arcs = np.concatenate([np.arange(n) for n in np.diff(groom.offsets)]) * lengths
    links = KDTree(groom.points).query_pairs(0.017, output_type="ndarray").astype(np.int32)
    rest = groom.points, ways / lengths[:, None], np.full(len(arcs), 5e-5)
    return Particles(groom, strands, arcs, *rest, links, np.ones(len(links)), reach=0.012, range=0.01)


@pytest.fixture(scope="module")
def groom() -> Groom:
    return tuft(6)


@pytest.fixture(scope="module")
def particles(groom) -> Particles:
    return particles_on(groom)


def cloud_of(points, directions, velocities=0.0) -> Cloud:
    speeds = np.broadcast_to(velocities, points.shape).astype(np.float32)
    return Cloud(np.ascontiguousarray(points), speeds, directions / np.linalg.norm(directions, axis=1, keepdims=True))


def deform(cloud, particles, groom, body=None, surface=None, **settings):
    influences = find_influences(particles, groom)
    return carry_strands(cloud, particles, groom, body, surface, None, Time(1, 24.0), influences, **settings)


def shaken(particles, seed):
    """Particles anywhere near, pointing anywhere, some to where they pointed away from."""
    rng = np.random.default_rng(seed)
    points = particles.points + 0.02 * rng.normal(size=particles.points.shape)
    directions = rng.normal(size=points.shape)
    directions[::5] = -particles.directions[::5]
    return cloud_of(points, directions, rng.normal(size=points.shape))


@pytest.mark.parametrize("linked", [True, False])
@pytest.mark.parametrize("segments", [6, 9])
def test_hair_that_is_moved_with_its_roots_is_right(linked, segments, particles):
    turn, shift, spin, drift = Rotation.from_rotvec((0.4, 2.0, -0.7)), (0.3, 1.2, -0.5), (3.0, -9.0, 2.0), (0.5, 1.0, 2)

    def moved(points):
        turned = turn.apply(points)
        return turned + shift, np.cross(spin, turned) + drift

    body = Mesh(moved(SKIN.points)[0], SKIN.triangles, moved(SKIN.points)[1])
    if not linked:
        particles = replace(particles, links=particles.links[:0], alignments=particles.alignments[:0])
    points, velocities = moved(particles.points)
    groom = tuft(segments)
    found = deform(cloud_of(points, turn.apply(particles.directions), velocities), particles, groom, body)
    assert np.abs(found.points - moved(groom.points)[0]).max() < 1e-12
    assert np.abs(found.velocities - moved(groom.points)[1]).max() < 1e-5


def test_lengths_stay_and_roots_go_with_the_body(particles, groom):
    body = Mesh(SKIN.points @ np.diag((1.0, -1.0, -1.0)) + (0.1, 0.2, 0.3), SKIN.triangles)
    found = deform(shaken(particles, 1), particles, groom, body)
    rest, now = (segment_lengths(some, groom.offsets) for some in (groom.points, found.points))
    assert np.abs(now - rest).max() < 1e-12
    motions, roots = motion_of_roots(body, groom)[0], groom.offsets[:-1]
    expected = np.einsum("sij,sj->si", motions[:, :, :3], groom.points[roots]) + motions[:, :, 3]
    assert np.abs(found.points[roots] - expected).max() < 1e-15


def test_velocities_are_the_derivative_where_particles_flow_evenly(particles, groom):
    """x' = A x, and each direction flows along; roots, which stand, count for a thousandth."""
    A, span = 4.0 * np.random.default_rng(3).normal(size=(3, 3)), 1e-5

    def at(time):
        flow = np.eye(3) + time * A
        points, speeds = particles.points @ flow.T, particles.points @ A.T
        return deform(cloud_of(points, particles.directions @ flow.T, speeds), particles, groom)

    before, now, after = (at(0.02 + way * span) for way in (-1.0, 0.0, 1.0))
    rate = (after.points - before.points) / (2 * span)
    assert np.abs(rate).max() > 0.5
    assert np.abs(now.velocities - rate).max() < 5e-3 * np.abs(rate).max()


def test_hair_bends_to_the_same_arc_as_particles():
    """Straight hair that becomes arcs of circles: what is carried goes the same way, to second order of the spacing."""

    def bent(points):
        share = -points[:, 1] / 0.1
        arc = np.stack([1.0 - np.cos(share), -np.sin(share)], axis=1)
        out = np.stack([np.cos(share), np.sin(share), 0.0 * share], axis=1)
        along = np.stack([np.sin(share), -np.cos(share), 0.0 * share], axis=1)
        middle = np.c_[0.1 * arc, points[:, 2]]
        return middle + points[:, :1] * out, along

    errors = []
    for fine in (1, 2):
        row = lay_strands(6 * fine, 0.1, 6 * fine, (0.0, -1.0, 0.0), (0.01 / fine, 0.0, 0.0), None, 0.0)
        dense = gather_tuft(row, Tuft(rows=4 * fine, apart=(0.0, 0.0, 0.01 / fine), stray=0.0))
        hair = lay_strands(1, 0.1, 40, (0.0, -1.0, 0.0), (0.0, 0.0, 0.0), None, 0.0)
        particles = particles_on(replace(dense, points=dense.points - np.array((0.023, 0.0, 0.014))))
        found = deform(cloud_of(*bent(particles.points)), particles, hair)
        errors.append(np.abs(found.points - bent(hair.points)[0]).max())
    assert errors[0] < 2e-3 and errors[1] < errors[0] / 2.5


def test_hair_where_particles_part_goes_with_one_side_and_does_not_lie_across():
    """Left and right halves go 8 cm apart, but for the roots; hair everywhere between them."""
    dense = gather_tuft(
        lay_strands(12, 0.1, 10, (0.0, -1.0, 0.0), (0.004, 0.0, 0.0), None, 0.0), Tuft(4, (0.0, 0.0, 0.005), 0.0)
    )
    particles = particles_on(dense)
    hair, middle = lay_strands(30, 0.1, 20, (0.0, -1.0, 0.0), (0.0015, 0.0, 0.0), None, 0.0), 0.022
    slope = np.where(particles.points[:, 0] > middle, 0.4, -0.4)
    away = particles.points - slope[:, None] * particles.points[:, 1:2] * (1.0, 0.0, 0.0)
    found = deform(cloud_of(away, np.c_[slope, -np.ones(len(slope)), 0.0 * slope]), particles, hair)
    tips = found.points[hair.offsets[1:] - 1, 0] - hair.points[hair.offsets[1:] - 1, 0]
    assert (np.abs(tips) > 0.03).all()


def test_hair_does_not_follow_particles_that_point_elsewhere():
    """Every other particle lies across the hair, which is straight: wherever it goes, hair stays."""
    groom = tuft(6, stray=0.0)
    particles = particles_on(groom)
    astray = np.arange(len(particles.points)) % 2 == 1
    directions = particles.directions.copy()
    directions[astray] = np.cross(directions[astray], (0.0, 0.0, 1.0))
    mixed = replace(particles, directions=directions)
    away = cloud_of(particles.points + astray[:, None] * (0.05, 0.0, 0.05), directions)
    assert np.abs(deform(away, mixed, groom).points - groom.points).max() < 0.02 * 0.07


def test_weights_are_one_in_all_and_fade_towards_the_eighth_particle(particles, groom):
    influences = find_influences(particles, groom)
    assert np.abs(influences.weights.sum(axis=1) - 1.0).max() < 1e-15
    everywhere = np.linspace(particles.points[5], particles.points[40], 400)
    line = replace(groom, points=everywhere, offsets=np.array([0, 400], np.int32))
    influences, shares = find_influences(particles, line), np.zeros((400, len(particles.points)))
    np.put_along_axis(shares, influences.particles, influences.weights, axis=1)
    assert np.abs(np.diff(shares, axis=0)).max() < 0.1  # none of them comes or goes at once


def test_interpolated_hair_inside_a_body_is_pushed_out(particles, groom, sphere):
    centre, radius, voxel = np.array([0.0, -0.09, 0.01]), 0.05, 0.005
    surface = bake(sphere(radius, centre, level=4), voxel, 8.0)
    still = cloud_of(particles.points, particles.directions)

    def heights(hair):
        return np.linalg.norm(hair.points - centre, axis=1) - radius

    assert heights(deform(still, particles, groom)).min() < -0.03
    found = deform(still, particles, groom, None, (surface,), thickness=2e-3)
    assert heights(found)[np.tile(np.arange(7) >= 5, 12)].min() > 2e-3 - 0.1 * voxel
    assert heights(found).min() > -1e-3
    rest, now = (segment_lengths(some.points, groom.offsets) for some in (groom, found))
    assert np.abs(now - rest).max() < 1e-12


def test_any_number_of_threads_gives_the_same_bytes(particles, groom, same_on_threads):
    same_on_threads(lambda: deform(shaken(particles, 5), particles, groom))


def test_too_few_particles_and_another_cloud_are_refused(particles, groom):
    few = {
        name: getattr(particles, name)[:INFLUENCES] for name in ("strands", "arcs", "points", "directions", "masses")
    }
    with pytest.raises(BadInput, match="7 particles are too few for interpolation"):
        find_influences(replace(particles, **few), groom)
    with pytest.raises(BadInput, match="a cloud of 83 particles, at rest there are 84"):
        deform(cloud_of(particles.points[1:], particles.directions[1:]), particles, groom)


DEFAULTS = {"sag": 0.1, "damping": 0.2, "gravity": 9.81, "interaction": Interaction(), "sag_free": None, "printed": ()}


def frames_of(particles, bodies, cuts=(), **settings):
    """Simulate a frame for every body, from the first on; return the clouds."""
    prepared, state, clouds = prepare_particles(particles, **DEFAULTS), None, []
    for frame, body in enumerate(bodies, 1):
        pair = (bodies[max(frame - 2, 0)], body)
        hair = simulate_particles(
            particles, pair, None, None, state, Time(frame, 24.0), cuts, prepared, interaction=Interaction(), **settings
        )
        clouds, state = [*clouds, hair.cloud], hair.state
    return clouds


def test_hair_follows_the_body_and_the_wind(curtain):
    particles = sample_particles(curtain, particles=300)
    still = frames_of(particles, 4 * [plate()])
    assert np.array_equal(still[0].points, particles.points)
    assert still[-1].points[:, 1].mean() < still[0].points[:, 1].mean()
    blown = frames_of(particles, 4 * [plate()], wind=Wind((3.0, 0.0, 0.0)))
    assert np.mean(blown[-1].points - still[-1].points, axis=0)[0] > 1e-3
    assert np.linalg.norm(blown[-1].directions, axis=1) == pytest.approx(1.0)


def test_over_a_cut_the_strands_that_they_carry_go_with_the_body_too(curtain):
    particles, there = sample_particles(curtain, particles=300), plate((5.0, 0.0, 0.0))
    groom = take(curtain, np.arange(0, 1000, 50))
    influences = find_influences(particles, groom)
    leapt, stayed = (
        [
            carry_strands(cloud, particles, groom, body, None, None, Time(frame, 24.0), influences)
            for frame, (cloud, body) in enumerate(zip(frames_of(particles, bodies, cuts=cuts), bodies, strict=True), 1)
        ]
        for bodies, cuts in ([2 * [plate()] + 2 * [there], (3,)], [4 * [plate()], ()])
    )
    for one, other in zip(leapt[2:], stayed[2:], strict=True):
        assert one.points == pytest.approx(other.points + np.array([5.0, 0.0, 0.0]), abs=1e-5)
        assert one.velocities == pytest.approx(other.velocities, abs=1e-3)
