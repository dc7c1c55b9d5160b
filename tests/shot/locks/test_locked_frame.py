"""Hair that sticks together is simulated once, and again by itself where that is not good enough."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.hdf5 import digest
from hairpipe.laws.settings import Collisions, Volume
from hairpipe.levelset.bake import bake
from hairpipe.shot.build import with_interactions
from hairpipe.shot.lock_guides import take_guides
from hairpipe.shot.locks import check_locks
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.solve.interactions import Interaction
from hairpipe.values import Ends, Mesh
from hairpipe.values.hair import AUDITED, FOLLOWED, RELEASED, TRIED, Touching

from ...strand_scenes import even_ball
from .bundle import CORNERS, SCENE, SEGMENTS, body, build_bundle, shot


@pytest.fixture
def hair():
    return build_bundle()


def followers(state):
    return np.flatnonzero(state.locks.follows)


def same(one, other):
    assert digest(one) == digest(other)


@pytest.fixture
def states(hair):
    return shot(hair, SCENE, 10)


def test_locks_form_when_connections_have_lasted_and_lead_few(hair, states):
    assert states[0].locks is None and [len(followers(state)) for state in states[1:3]] == [0, 0]
    left = len(hair.groom.ids) - len(followers(states[-1]))
    assert left < 0.5 * len(hair.groom.ids)
    sizes = np.bincount(states[-1].locks.leaders)
    assert 1 < sizes.max() <= 8
    owners = np.searchsorted(hair.layout.offsets, states[-1].stuck, side="right") - 1
    np.testing.assert_array_equal(states[-1].locks.leaders[owners], owners)  # guides alone stick


def test_hair_is_where_it_is_without_locks(hair, states):
    every = shot(hair, replace(SCENE, locks=None), 10)
    apart = [hair.layout.axis(a.positions) - hair.layout.axis(b.positions) for a, b in zip(states, every, strict=True)]
    rms = [np.sqrt((way**2).sum(axis=1).mean()) for way in apart]
    went = hair.layout.axis(every[-1].positions) - hair.layout.axis(every[0].positions)
    assert rms[2] == 0.0 and max(rms) < 0.1 * np.sqrt((went**2).sum(axis=1).mean())


def test_lengths_stay(hair, states):
    points = hair.layout.axis(states[-1].positions).reshape(-1, SEGMENTS + 1, 3)[followers(states[-1])]
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=1), axis=2), 0.06 / SEGMENTS, rtol=1e-9)


def test_a_shot_that_is_resumed_is_the_same_to_the_bit_on_any_number_of_threads(hair, states, threads):
    threads(1)
    same(shot(hair, SCENE, 4, states[5], 6)[-1], states[9])


def test_hairs_whose_guides_disagree_are_simulated_again(hair, states):
    strict = replace(SCENE, locks=replace(SCENE.locks, tolerance=1e-9, after=1000))
    state = shot(hair, strict, 2, states[-1], 10)[-1]
    assert not len(followers(state))
    speeds = hair.layout.axis(state.velocities)
    assert np.isfinite(state.positions).all() and np.abs(speeds).max() < 5.0


def test_locks_that_are_all_audited_all_the_time_change_nothing(hair):
    audited = replace(SCENE, locks=replace(SCENE.locks, after=1, audit=1.0, tolerance=5e-4))  # all move farther
    every, checked = shot(hair, replace(SCENE, locks=None), 7)[-1], shot(hair, audited, 7)
    for values in ("positions", "velocities"):
        np.testing.assert_array_equal(*(hair.layout.axis(getattr(state, values)) for state in (checked[-1], every)))
    np.testing.assert_array_equal(checked[-1].stuck, every.stuck)
    audits = [state.locks.audit for state in checked[1:]]
    assert audits[1] is None and audits[-1].hairs.sum() > len(hair.groom.ids) // 2
    errors = audits[-1].errors
    went = np.linalg.norm(hair.layout.axis(checked[-1].positions) - hair.layout.axis(checked[-2].positions), axis=1)
    assert 0.0 < errors.max() < 0.1 * went.max()


def test_audited_strands_rotate_and_are_not_guides(hair):
    audited = replace(SCENE, locks=replace(SCENE.locks, audit=0.3, tolerance=5e-4))  # all move farther
    states, turns = shot(hair, audited, 14), set()
    owners = np.repeat(np.arange(len(hair.groom.ids)), np.diff(hair.layout.offsets))
    for before, state in pairwise(states[5:]):
        now = state.locks
        among = np.flatnonzero(now.roles == AUDITED)
        turns.add(tuple(among))
        followed = owners[now.places.points[np.arange(FOLLOWED) < now.places.counts[:, None]]]
        assert not now.compared[followed].any()
        assert (now.leaders[among] == among).all()
        assert np.bincount(now.guides[~now.released]).max() <= SCENE.locks.most
        if now.since or not (before.locks.roles == AUDITED).any():
            assert now.audit is None
        else:
            locks = before.locks.guides[before.locks.roles == AUDITED]
            np.testing.assert_array_equal(now.audit.hairs, np.unique(locks, return_counts=True)[1])
    assert len(turns - {()}) >= 3
    same(shot(hair, audited, 4, states[7], 8)[-1], states[11])


def test_hairs_that_fail_an_audit_follow_only_after_connections_last_again(hair):
    locks = replace(SCENE.locks, after=3, audit=0.5)
    states = shot(hair, replace(SCENE, locks=locks), 9)
    last = next(k for k in range(8, 4, -1) if states[k].locks.compared.any() and states[k].locks.since == 2)
    who = states[last].locks.compared
    good = shot(hair, replace(SCENE, locks=replace(locks, tolerance=0.1, audit=0.0)), 1, states[last], last + 1)[-1]
    bad = replace(SCENE, locks=replace(locks, tolerance=1e-12, audit=0.0))
    released = shot(hair, bad, 3, states[last], last + 1)[1:]
    assert np.isin(np.flatnonzero(who), followers(good)).all()
    for state in released[:3]:
        assert not np.isin(np.flatnonzero(who), followers(state)).any()


def test_parted_hair_is_tried_with_other_guides_and_follows_within_tolerance(hair, states):
    strict = replace(SCENE, locks=replace(SCENE.locks, tolerance=1e-9, part=2.0, after=1000))
    apart = shot(hair, strict, 1, states[-1], 10)[-1]
    who = np.flatnonzero(apart.locks.roles == RELEASED)
    np.testing.assert_array_equal(who, followers(states[-1]))
    np.testing.assert_array_equal(apart.locks.guides[who], states[-1].locks.leaders[who])
    tried = replace(SCENE, locks=replace(SCENE.locks, part=2.0, most=25))  # nothing joins by its connections
    back = shot(hair, tried, 4, apart, 11)[1:]
    begun = next(k for k, state in enumerate(back) if state.locks.since == 0)
    assert not np.isin(who, followers(back[begun])).any()
    assert (back[begun].locks.roles[who] == TRIED).all()
    again = who[np.isin(who, followers(back[begun + 2]))]
    assert len(again) > len(who) // 2
    leaders, tried_by = back[begun + 2].locks.leaders, back[begun + 1].locks
    audit = back[begun + 2].locks.audit
    assert (audit.hairs.sum() if audit else 0) == (tried_by.roles == AUDITED).sum()
    rows = np.repeat(np.flatnonzero(tried_by.interpolated), SEGMENTS + 1)
    followed = tried_by.places.points // (SEGMENTS + 1)
    valid = np.arange(FOLLOWED) < tried_by.places.counts[:, None]
    for s in again:
        times = np.bincount(followed[rows == s][valid[rows == s]])
        assert times[leaders[s]] == times.max()  # A guide with the most of its places; all have room here.
    never = shot(hair, replace(tried, locks=replace(tried.locks, tolerance=1e-9)), 4, apart, 11)[-1]
    assert not np.isin(who, followers(never)).any()


def test_ends_that_go_as_the_body_does_lead_guides_as_it_does(hair, states):
    free = np.full((2, len(hair.groom.ids), 3, 4), np.nan)
    led = shot(hair, SCENE, 10, driver=lambda time: Ends(*motion_of_roots(body(time), hair.groom), *free))
    assert len(followers(led[-1])) > 0
    same(led[-1], states[-1])


def test_guides_taken_out_and_put_back_are_what_they_were(hair, states):
    state = states[-1]
    guides = take_guides(hair, state.locks.leaders)
    strands = guides.strands
    follower = np.setdiff1d(np.arange(len(state.locks.leaders)), strands)[0]
    points = np.sort(np.array([*strands[:2], follower]) * (SEGMENTS + 1) + 4).astype(np.int32)
    touching = Touching(points, np.full(3, 2, np.int8), np.arange(6.0).reshape(3, 2), 0.1 * np.eye(3), np.eye(3))
    back = guides.put(state, guides.state_of(replace(state, touching=touching)))
    led = np.isin(points // (SEGMENTS + 1), strands)
    for name in ("points", "states", "damping", "slid", "normals"):
        np.testing.assert_array_equal(getattr(back.touching, name), getattr(touching, name)[led])
    same(replace(back, locks=state.locks, touching=state.touching), state)
    np.testing.assert_array_equal(
        guides.hair.groom.points.reshape(len(strands), -1, 3)[3],
        hair.groom.points.reshape(-1, SEGMENTS + 1, 3)[strands[3]],
    )
    sizes = np.bincount(state.locks.leaders)[strands]
    np.testing.assert_array_equal(guides.hair.widths[:: SEGMENTS + 1], np.sqrt(sizes))


@pytest.mark.parametrize(
    ("scene", "reported"),
    [
        (replace(SCENE, stiction=None), "locks require stiction"),
        (replace(SCENE, collisions=Collisions(solver="sweep")), "coupled contact solver"),
        (replace(SCENE, volume=Volume()), "coupled contact solver"),
        (with_interactions(SCENE, Interaction()), "act on guides only"),
    ],
)
def test_hair_that_cannot_be_in_locks_is_refused_at_the_first_frame(hair, scene, reported):
    with pytest.raises(BadInput, match=reported):
        shot(hair, scene, 1)


def test_hair_whose_tips_are_held_is_refused(hair):
    groom = hair.groom
    ends = Ends(*motion_of_roots(None, groom), *(np.zeros((len(groom.ids), 3, 4)) for _ in range(2)))
    with pytest.raises(BadInput, match="free tip"):
        check_locks(hair, ends, SCENE)


CENTRE, RADIUS = np.array([0.06, -0.012, -0.031]), 0.03


def still(time):
    return Mesh(CORNERS, np.array([[0, 1, 2]], np.int32), np.zeros((3, 3)))


@pytest.fixture(params=["free", "ball"])
def surfaces(request):
    """Nothing, or a ball that the bundle sinks onto."""
    if request.param == "free":
        return ()
    ball = bake(even_ball(CENTRE, RADIUS, 400), 0.004, 6.0)
    return ((ball, ball),)


AUDITS = replace(SCENE, locks=replace(SCENE.locks, audit=0.3))
"""Other locks are audited after every second frame, while hair moves."""


def motion_of(hair, states):
    """The largest displacement of a point in a frame [m], and the rms speed [m/s], in the last six of some frames."""
    points = np.array([hair.layout.axis(state.positions) for state in states[-6:]])
    velocities = np.array([hair.layout.axis(state.velocities) for state in states[-6:]])
    farthest = np.linalg.norm(np.diff(points, axis=0), axis=2).max()
    return farthest, np.sqrt((velocities**2).sum(axis=2).mean())


@pytest.mark.parametrize("model", ["network", "rod"])
def test_hair_in_locks_comes_to_rest(model, surfaces):
    """Within 2.5 s. Guides change until then."""
    hair = build_bundle(model)
    states = shot(hair, AUDITS, 60, driver=still, surfaces=surfaces)
    assert any(state.locks.compared.any() for state in states[:20] if state.locks)
    farthest, speed = motion_of(hair, states)
    assert farthest < 1e-5 and speed < 1e-4
    leaders = [state.locks.leaders for state in states[-6:]]
    assert (leaders[0] != np.arange(len(leaders[0]))).any()
    assert all(np.array_equal(now, leaders[0]) for now in leaders)


@pytest.mark.parametrize("seed", range(3))
def test_hair_that_sticks_nearer_than_the_reach_comes_to_rest(seed):
    """Its connections push: along the direction at the prediction, they would move it for ever."""
    hair = build_bundle("rod", seed)
    farthest, speed = motion_of(hair, shot(hair, replace(SCENE, locks=None, collisions=None), 66, driver=still))
    assert farthest < 1e-5 and speed < 1e-4
