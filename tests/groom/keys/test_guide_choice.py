"""Guides chosen by their error: exact where strands move alike, least where they do not, and reproduced by the node."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.groom.guide_choice import Choice, farthest_roots, fit_guidance, record_motions
from hairpipe.groom.interpolating import interpolated
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands
from hairpipe.measure.following import COLUMNS, Guiding, Sample, measure_following
from hairpipe.nodes.choose_guides import choose_guides
from hairpipe.nodes.measure_guides import measure_guides
from hairpipe.values import Groom, Strands
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take

FRAMES = 5
KINDS = 4
"""Kinds of motion in the tuft: strand s moves as kind s % KINDS does, so the nearest roots move otherwise."""


@pytest.fixture(scope="module")
def groom() -> Groom:
    """A tuft of 24 strands of 6 segments that stray."""
    row = lay_strands(8, 0.1, 6, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0)
    return gather_tuft(row, Tuft(rows=3, apart=(0.0, 0.0, 0.01), stray=10.0))


def still(groom: Groom) -> tuple[np.ndarray, np.ndarray]:
    motions = np.tile(np.eye(3, 4), (len(groom.ids), 1, 1))
    return motions, 0.0 * motions


def sway(groom: Groom, frame: int, bends: Callable[[int], np.ndarray]) -> Strands:
    """Turn segment k of every strand by k times the rotation vector of its motion."""
    points = groom.points.copy()
    for s, (begin, end) in enumerate(zip(groom.offsets, groom.offsets[1:], strict=False)):
        turns = Rotation.from_rotvec(np.arange(end - begin - 1)[:, None] * frame * bends(s))
        points[begin + 1 : end] = points[begin] + np.cumsum(
            turns.apply(np.diff(groom.points[begin:end], axis=0)), axis=0
        )
    return Strands(points, np.zeros(points.shape, np.float32), groom.offsets, 8e-5)


@pytest.fixture(scope="module")
def kinds() -> np.ndarray:
    """Rotation vectors of the kinds of motion, about axes across the strands, (KINDS, 3)."""
    return np.array([[0.03, 0.0, 0.0], [-0.03, 0.0, 0.0], [0.0, 0.0, 0.04], [0.0, 0.0, -0.02]])


@pytest.fixture(scope="module")
def shot(groom, kinds) -> dict[int, Strands]:
    """Hair of which each strand moves as one of the kinds."""
    return {frame: sway(groom, frame, lambda s: kinds[s % KINDS]) for frame in range(FRAMES)}


@pytest.fixture(scope="module")
def guiding(groom, shot) -> Guiding:
    return Guiding(groom, lambda frame: Sample(shot[frame], still(groom), (), None), [*shot], 2)


def following(groom, shot, strands, guidance):
    keys = take(groom, strands)
    weights = weigh_keys(keys, groom, 30.0, guidance)
    return {f: interpolated(take(hair, strands), keys, groom, weights, still(groom)) for f, hair in shot.items()}


def error(groom, shot, strands, guidance) -> float:
    shown = following(groom, shot, strands, guidance)
    return float(np.sqrt(measure_following((shown[f], shot[f], ()) for f in shot).squares.mean()))


def test_one_guide_of_each_motion_is_chosen(guiding):
    found = guiding.find(KINDS, None, "motion")
    assert sorted(found.keys.ids % KINDS) == [*range(KINDS)]


def test_strands_follow_guides_that_move_as_they_do(groom, shot, guiding):
    found = guiding.find(KINDS, None, "motion")
    strands = np.flatnonzero(np.isin(groom.ids, found.keys.ids))
    chosen, nearest = (error(groom, shot, strands, g) for g in (found.guidance, None))
    assert chosen < 0.25 * nearest
    assert np.array_equal(found.guidance.ids[:, 0] % KINDS, groom.ids % KINDS)


def test_choice_is_that_of_all_pairs(groom, shot, guiding):
    found = guiding.find(1, None, "motion").keys.ids[0]
    costs = [guiding.fit(take(groom, np.array([s])))[0].errors["rms [m]"][0] for s in range(len(groom.ids))]
    assert costs[int(np.flatnonzero(groom.ids == found)[0])] == pytest.approx(min(costs), rel=0.02)


def test_error_falls_to_zero_as_all_strands_become_guides(guiding, groom):
    rms = [guiding.find(n, None, "motion").errors["rms [m]"][1] for n in (2, 4, 12, len(groom.ids))]
    assert rms == sorted(rms, reverse=True)
    assert rms[-1] == 0.0


def test_weights_are_those_of_least_squares(groom, shot):
    """A strand half way between two motions has weights of one half, which no single guide has."""
    bends = {0: -0.03, 2: 0.03}
    frames = (-2, -1, 1, 2)
    samples = [(sway(groom, f, lambda s: np.array([bends.get(s, 0.0), 0.0, 0.0])), still(groom)) for f in frames]
    strands = np.array([0, 2])
    keys = take(groom, strands)
    turns = record_motions(keys, [(take(hair, strands), still(keys)) for hair, _ in samples])
    found = fit_guidance(groom, record_motions(groom, samples), keys, turns)
    assert found.weights[1, :2] == pytest.approx(0.5, abs=0.05)


def test_guidance_keeps_lengths_and_roots(groom, guiding):
    found = guiding.find(3, None, "motion").guidance
    assert segment_lengths(found.rest, groom.offsets) == pytest.approx(segment_lengths(groom.points, groom.offsets))
    assert np.array_equal(found.rest[groom.offsets[:-1]], groom.points[groom.offsets[:-1]])
    assert found.weights.sum(axis=1) == pytest.approx(1.0)
    assert (found.weights >= 0.0).all()


def test_fewest_guides_keep_a_tolerance(guiding):
    found = guiding.find(None, 1e-3, "motion")
    assert max(found.errors["95 % above floor [m]"]) <= 1e-3
    fewer = guiding.find(len(found.keys.ids) - 1, None, "motion")
    assert max(fewer.errors["95 % above floor [m]"]) > 1e-3


def test_farthest_roots_are_the_farthest(groom):
    roots = groom.points[groom.offsets[:-1]]
    chosen = farthest_roots(groom, 5)
    for n in range(1, 5):
        apart = np.linalg.norm(roots[:, None] - roots[chosen[:n]], axis=2).min(axis=1)
        assert apart[chosen[n]] == apart.max()


def test_floor_is_the_variance_of_a_member(groom):
    """Two members a distance d apart differ by chance of variance d^2 / 2; an error of that size is none."""
    hair = Strands(groom.points, np.zeros(groom.points.shape, np.float32), groom.offsets, 8e-5)
    apart = [
        Strands(groom.points + np.array([x, 0.0, 0.0]), hair.velocities, groom.offsets, 8e-5) for x in (2e-3, 3e-3)
    ]
    found = measure_following([(apart[1], hair, (apart[0],))])
    assert found.floor == pytest.approx(0.5 * 4e-6)
    assert found.bound == pytest.approx(np.sqrt(9e-6 - 2e-6))


def test_nodes_give_what_is_measured(groom, shot):
    frames = Frames(tuple(shot), shot.__getitem__)
    keys, guidance, bound = choose_guides(groom, frames, None, None, (frames,), None, None, guides=4, samples=2)
    assert bound.names == COLUMNS
    strands = np.flatnonzero(np.isin(groom.ids, keys.ids))
    followed = following(groom, shot, strands, guidance)
    table = measure_guides(Frames(tuple(shot), followed.__getitem__), frames, None, skip=1)
    fitted, between = bound["rms [m]"]
    assert table["rms [m]"][0] ** 2 == pytest.approx((fitted**2 + between**2) / 2, rel=1e-6)


def test_guides_simulated_alone_are_fitted(groom, shot):
    """Guides that bend half as far as the hair: the rest shape has what is constant of the difference."""
    frames = Frames(tuple(shot), shot.__getitem__)
    keys = take(groom, np.array([1, 6, 12, 19]))
    alone = {f: take(shot[f], np.array([1, 6, 12, 19])) for f in shot}
    given = Frames(tuple(alone), alone.__getitem__)
    one = choose_guides(groom, frames, None, None, None, keys, given, samples=2)
    two = choose_guides(groom, frames, None, None, None, keys, None, samples=2)
    assert np.array_equal(one.guidance.rest, two.guidance.rest)


@pytest.mark.parametrize("given", [{}, {"guides": 4, "tolerance": 1e-3}])
def test_a_number_or_a_tolerance_is_needed(groom, shot, given):
    frames = Frames(tuple(shot), shot.__getitem__)
    with pytest.raises(BadInput, match="guides or tolerance"):
        choose_guides(groom, frames, None, None, None, None, None, samples=2, **given)


def test_guidance_of_another_groom_is_refused(groom, guiding):
    found = guiding.find(4, None, "motion")
    other = take(groom, np.arange(9))
    with pytest.raises(BadInput, match="not that of the groom"):
        weigh_keys(found.keys, other, 30.0, found.guidance)
    with pytest.raises(BadInput, match="not a key"):
        weigh_keys(take(found.keys, np.arange(3)), groom, 30.0, found.guidance)


def test_choice_is_the_same_in_any_order_of_requests(groom, guiding):
    one, two = (Choice(groom, guiding.motions) for _ in range(2))
    two.guides(3)
    assert np.array_equal(one.guides(6), two.guides(6))
