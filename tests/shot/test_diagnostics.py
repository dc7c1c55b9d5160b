"""Roots deep inside a body, and segments stretched far, are named once."""

import warnings
from dataclasses import replace

import pytest

from hairpipe.laws.settings import Collisions, StrainLimit
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation
from hairpipe.shot import simulate
from hairpipe.shot.shot import Frame
from hairpipe.strands.material import Material


@pytest.fixture
def shot(scene, straight):
    """Three strands of 10 mm a segment, the second moved down so that its root is 30 mm lower."""
    found = scene([straight(0.1, 10, [1.0, 0.2, 0.0]) for _ in range(3)])
    found.state.positions[:, 1, 1] -= 0.03
    return found


def test_roots_deeper_than_a_segment_are_named(shot, box):
    block = bake(box((-0.2, -0.2, -0.2), (0.2, 0.005, 0.2)), 0.01, 3.0)
    body = [build_collider_field(block, block, 1 / 24, Interpolation.two_sided)]
    with pytest.warns(UserWarning, match=r"1 of 3 roots .* the deepest by 35 mm: strands 1 \(roots on the skin"):
        simulate.warn_of_deep_roots(shot.hair, shot.state.positions, body)
    shot.state.positions[:, 1, 1] += 0.03
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate.warn_of_deep_roots(shot.hair, shot.state.positions, body)


def test_the_largest_stretch_is_named_once_and_again_when_it_has_grown(shot):
    x, scene = shot.state.positions, shot.scene
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert simulate.warn_of_stretch(shot.hair, x, scene, 7, 1.0) == 1.0
    x[-1, :, 2:] += 1.3 * (x[-1, :, 2:] - x[-3, :, 2:])  # the last strand fills its block
    with pytest.warns(UserWarning, match=r"strand 2 is stretched to 2.3 times its length at frame 7, .* 1.02"):
        reported = simulate.warn_of_stretch(shot.hair, x, scene, 7, 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert simulate.warn_of_stretch(shot.hair, x, scene, 8, reported) == reported
    assert reported == pytest.approx(2.3)


def grow(groom, body, factors):
    """Report bodies that are scaled frame by frame; the messages, and the ratio at the end."""
    size, messages = (1.0, 1.0), []
    bodies = [replace(body, points=factor * body.points) for factor in factors]
    for frame in range(1, len(bodies)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            size = simulate.warn_of_growth(groom, (bodies[frame - 1], bodies[frame]), frame, *size)
        messages += [str(warning.message) for warning in caught]
    return messages, size[0]


def test_skin_that_grows_is_named_at_first_and_when_it_has_grown_much_more(shot):
    messages, ratio = grow(shot.hair.groom, shot.body, [1.0 + 0.0251 * frame for frame in range(25)])
    assert ratio == pytest.approx(1.6024)
    assert [message.partition(",")[0] for message in messages] == [
        f"the skin at the roots has grown by {percent} % since the first frame" for percent in (10, 33, 60)
    ]
    messages, ratio = grow(shot.hair.groom, shot.body, [1.0, 0.85])
    assert ratio == pytest.approx(0.85) and "has shrunk by 15 %" in messages[0]
    assert grow(shot.hair.groom, shot.body, [1.0, 1.05, 0.95, 1.0])[0] == []


def test_a_shot_names_skin_that_grows(shot):
    larger = replace(shot.body, points=1.2 * shot.body.points)
    simulation = simulate.StrandSimulation(shot.hair, shot.scene)
    with pytest.warns(UserWarning, match="has grown by 20 % .*at frame 1, and hair keeps its length"):
        state = simulation.advance(shot.state, Frame((shot.body, larger), (), (), 0.0, 1 / 24))
    assert state.grown == state.grown_reported == pytest.approx(1.2)


def test_the_published_solver_of_contact_is_warned_of(shot):
    with pytest.warns(UserWarning, match=r'"sweep" adds energy to strands that rest on each other .*"coupled"'):
        simulate.warn_of_sweep(replace(shot.scene, collisions=Collisions(solver="sweep")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate.warn_of_sweep(replace(shot.scene, collisions=Collisions()))
        simulate.warn_of_sweep(shot.scene)


@pytest.mark.parametrize("model", ["network", "rod"])
def test_strands_that_their_weight_stretches_beyond_the_limit_are_named(scene, straight, model):
    """By rho g L / E, times the softening: 3.9 % of a strand of 30 cm, 1.3 % of one of 10 cm."""
    strands = [straight(length, 10, [0, -1, 0]) for length in (0.1, 0.3)]
    shot = scene(strands, Material(young=1e9, softening=1e4), model=model)
    with pytest.warns(
        UserWarning, match=r"the weight of 1 strands stretches them by up to 0.0\d+, .*: strands 1 \(a lar"
    ):
        simulate.warn_of_weight(shot.hair, shot.scene)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for limit in (StrainLimit(0.06), None):
            simulate.warn_of_weight(shot.hair, replace(shot.scene, strain=limit))
