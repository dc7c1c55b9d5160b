"""Forces of stiction and contact distances that differ from segment to segment, in closed form and against numbers."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.contact.collision import collide
from hairpipe.contact.hair import HairContacts
from hairpipe.contact.repulsion import sweep
from hairpipe.contact.stiction import Connections, linearise, stiffest
from hairpipe.geometry.proximity import near_pairs
from hairpipe.laws.settings import Collisions, Force, Stiction, Thickness
from hairpipe.shot.build import surroundings_of
from hairpipe.shot.simulate import start
from hairpipe.solve.couplings import Couplings, coupling_rows, find_incidence
from hairpipe.solve.interactions import Prediction
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

from ...laws.checks import check_law

FORCE = 2e-5
STICTION = Stiction(force=Force(FORCE), damping=0.0)


def pulls(x, connections, grips):
    """Force on every point at rest [N]."""
    count = len(connections.segments)
    couplings = Couplings(*connections, np.empty(count, np.bool_), np.zeros((count, 8)))
    masses, ones = np.full(len(x), 1e-8), np.ones(len(x))
    linearise(
        connections,
        Prediction(x, 0 * x, 0 * x, masses, ones, ones > 0, 1.0, 1.0, 1.0),
        STICTION,
        couplings,
        ones,
        grips,
    )
    return coupling_rows(couplings, find_incidence(connections.segments, len(x))).push


@pytest.mark.parametrize(("first", "second"), [(1.0, 0.25), (0.5, 0.5), (1.0, 0.0)])
def test_two_segments_pull_with_the_geometric_mean_of_their_forces(first, second):
    gap = 0.5 * (STICTION.reach + STICTION.release)
    x = np.array([[0.0, 0, 0], [0, 0.01, 0], [gap, 0, 0], [gap, 0.01, 0]])
    grips = np.sqrt([first, 1.0, second, 1.0])
    found = pulls(x, Connections(np.array([[0, 2]], np.int32), np.array([[0.5, 0.5]])), grips)
    half = 0.5 * FORCE * np.sqrt(first * second)  # at half of the way from reach to release
    np.testing.assert_allclose(found[:, 0], 0.5 * half * np.array([1.0, 1.0, -1.0, -1.0]), rtol=1e-12)


def random_web():
    rng = np.random.default_rng(3)
    pairs = np.unique(np.stack([rng.integers(0, 19, 40), 20 + rng.integers(0, 19, 40)], 1), axis=0).astype(np.int32)
    x = np.concatenate([4e-4 * rng.normal(size=(20, 3)).cumsum(axis=0) for _ in range(2)])
    return x, Connections(pairs, rng.random(pairs.shape)), rng.uniform(0.1, 1.0, len(x))


def test_force_of_unequal_segments_is_the_slope_of_their_energy():
    x, connections, grips = random_web()
    x[20:] += 2e-4
    stiffness = FORCE / (STICTION.release - STICTION.reach) * grips[connections.segments].prod(axis=1)

    def energy(points):
        s = connections.fractions[:, :, None]
        ends = (1 - s) * points[connections.segments] + s * points[connections.segments + 1]
        longer = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) - STICTION.reach
        slack = STICTION.release - STICTION.reach
        beyond = slack**2 * (0.5 + np.log(np.maximum(longer, slack) / slack))  # breaks with a force k slack^2 / longer
        return np.where(longer < slack, 0.5 * longer**2, beyond) @ stiffness

    check_law(energy, lambda points: pulls(points, connections, grips), None, x, steps=(1e-8, 0.0))


def test_the_bound_of_the_frequency_has_the_factors_of_pairs():
    _, connections, _ = random_web()
    masses = np.full(40, 1e-8)
    whole = stiffest(connections, masses, STICTION)
    assert stiffest(connections, masses, STICTION, np.full(40, 0.5)) == pytest.approx(0.25 * whole)


@pytest.mark.parametrize("gap", [0.05, 4e-4])
def test_a_crossing_ends_at_the_mean_thickness(gap):
    """Of a hair of 0.6 and one of 0.2 mm: 0.4 mm."""
    before = np.array([[-0.01, gap, 0], [0.01, gap, 0], [0, 0, -0.01], [0, 0, 0.01]])
    after = before - np.outer([1, 1, 0, 0], [0.0, 0.1, 0.0])
    law, widths = Collisions(Thickness(6e-4)), np.array([1.0, 1.0, 1 / 3, 1 / 3])
    found = collide(before, after, np.full(4, 1e-8), np.array([0, 2, 4], np.int32), 0.01, law, None, widths)
    ended = after + 0.01 * found.change
    assert ended[0, 1] - ended[2, 1] == pytest.approx(4e-4)


def test_the_published_impulses_stop_at_the_mean_thickness():
    x = np.array([[-0.01, 5e-4, 0], [0.01, 5e-4, 0], [0, 0, -0.01], [0, 0, 0.01]])
    offsets, law = np.array([0, 2, 4], np.int32), Collisions(Thickness(6e-4), stiffness=1e4)
    for widths, pushed in ((None, True), (np.array([1.0, 1.0, 1 / 3, 1 / 3]), False)):
        v = np.zeros((4, 3))
        sweep(near_pairs(x, offsets, 1e-3), x, v, np.full(4, 1e-8), law, 0.01, widths, elastic=True)
        assert bool(v.any()) is pushed  # 0.5 mm apart: nearer than 0.6 mm, and not nearer than 0.4 mm


def test_pairs_are_near_within_the_mean_of_their_widths():
    x = np.array([[0.0, 0, 0], [0.01, 0, 0], [0, 1e-3, 0], [0.01, 1e-3, 0], [0, -1e-3, 0], [0.01, -1e-3, 0]])
    widths = np.repeat([1.0, 0.5, 0.1], 2)
    found = near_pairs(x, np.arange(0, 7, 2, dtype=np.int32), 1.5e-3, None, widths)
    np.testing.assert_array_equal(found.segments, [[0, 2]])  # 1.125 and 0.825 mm, at 1 mm


def varied(shot, factors, material=None, **touching):
    """Return a shot of hair with a map of factors, one a strand, on settings of contact that name it."""
    groom = replace(shot.hair.groom, maps={"own": np.array(factors)})
    shot.hair = build_hair(groom, material or Material(), "rod")
    shot.scene = replace(shot.scene, **touching)
    shot.state = start(shot.hair, shot.body, shot.scene)
    return shot


def crossing(x, y=0.03, count=25):
    """A hair that falls across another one, from a place along x."""
    along = np.linspace(0.0, 1.0, count)[:, None]
    return [[x, 0.0, 0.0] + along * [0.045, 0, 0], [x + y, -2.0e-3, -0.02] + along * [0, 0, 0.03]]


def lowest_gap(shot):
    pairs = near_pairs(shot.axis, shot.hair.layout.offsets, 4e-3)
    strands = np.searchsorted(shot.hair.layout.offsets, pairs.segments, side="right") - 1
    return pairs.distances[strands[:, 0] != strands[:, 1]].min()


def fallen(scene, strands, factors, touching):
    shot = scene(strands, step=1 / 96, drag=8.0, model="rod")
    return varied(shot, factors, **touching).run(0.75)


def test_a_thick_hair_rests_on_a_thin_one_at_their_mean_thickness(scene):
    """As two hairs of that thickness do, up to what friction holds: times of contact follow the setting."""
    unequal = fallen(scene, crossing(0.0), (1.0, 0.2), {"collisions": Collisions(Thickness(1e-3, map="own"))})
    equal = fallen(scene, crossing(0.0), (1.0, 1.0), {"collisions": Collisions(Thickness(6e-4))})
    assert 0.9 * 6e-4 < lowest_gap(unequal) < 1.05 * 6e-4
    np.testing.assert_allclose(unequal.axis, equal.axis, rtol=0, atol=1e-4)


def test_pairs_of_two_thicknesses_in_one_groom_rest_as_each_alone(scene):
    touching = {"collisions": Collisions(Thickness(1e-3, map="own"))}
    both = fallen(scene, [*crossing(0.0), *crossing(1.0)], (1.0, 1.0, 0.3, 0.3), touching).axis.reshape(2, 50, 3)
    for place, (found, thickness) in enumerate(zip(both, (1e-3, 3e-4), strict=True)):
        alone = fallen(scene, crossing(float(place)), (1, 1), {"collisions": Collisions(Thickness(thickness))})
        np.testing.assert_allclose(found, alone.axis, rtol=0, atol=1.5e-4)  # of 0.7 mm between the two
        assert 0.8 * thickness < lowest_gap(alone) < 1.1 * thickness


def test_hair_without_force_connects_to_nothing(scene, straight):
    lines = [straight(0.05, 10, [1, 0, 0]) + np.array([0, 0, 4e-4 * k]) for k in range(3)]
    touching = {"stiction": Stiction(reach=1e-3, release=2e-3, force=Force(2e-5, map="own"))}
    stuck = varied(scene(lines, model="rod"), (1.0, 0.0, 0.5), **touching).run(1 / 24).state.stuck // 11
    assert len(stuck) and set(map(tuple, stuck)) == {(0, 2)}


def test_factors_of_contact_are_those_of_the_values(scene, straight):
    lines = [straight(0.05, 4, [1, 0, 0]) + np.array([0, 0, 0.01 * k]) for k in range(2)]
    profile = ((0.0, 1.0), (1.0, 0.2))
    touching = {
        "stiction": Stiction(force=Force(2e-5, map="own", profile=profile)),
        "collisions": Collisions(Thickness(4e-4, profile=profile)),
    }
    shot = varied(scene(lines, model="rod"), (1.0, 0.25), **touching)
    around = surroundings_of(shot.hair, shot.hair.model, shot.state, (), shot.scene, 0.0)
    contacts = next(each for each in around.interactions if isinstance(each, HairContacts))
    along = np.array([0.9, 0.7, 0.5, 0.3])  # of the profile, in the middle of the four segments
    forces = contacts.stiction.force.value * contacts.grips**2
    np.testing.assert_allclose(forces.reshape(2, 5)[:, :4], 2e-5 * np.outer([1.0, 0.25], along))
    thickness = contacts.collisions.thickness.value * contacts.thick
    np.testing.assert_allclose(thickness.reshape(2, 5)[:, :4], 4e-4 * np.tile(along, (2, 1)))
