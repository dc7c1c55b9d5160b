"""Feet that rest stand on the body's floor, where one asks for it; and one is told where they do not."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.posing import Playback, pose_at, standing_height
from hairpipe.body.retarget import build_retarget

PLAIN = Playback(up=None, reference=None, unit=None, skip=None, joints=())
FEET = replace(PLAIN, floor="feet")


def raised(clip, by: float):
    """The clip with its performer so much higher [m]."""
    values = clip.values.copy()
    values[:, 1] += by
    return replace(clip, values=values)


def walking(clip):
    """The performer goes along with one leg lifted in turn; the other foot is down."""
    values, frames = clip.values.copy(), np.arange(len(clip.values))
    names = [joint for joint, channels in zip(clip.names, clip.channels, strict=True) for _ in channels]
    for name, lifted in (("LeftUpLeg", frames % 40 < 20), ("RightUpLeg", frames % 40 >= 20)):
        values[:, names.index(name) + 1] = 40.0 * lifted * np.sin(np.pi * (frames % 20) / 20.0)
    return replace(clip, values=values)


@pytest.mark.parametrize("off", [-0.09, 0.0, 0.05, 0.9])
def test_the_height_at_which_feet_rest_is_found(skeleton, make_clip, off):
    for clip in (make_clip(60), walking(make_clip(60)), make_clip(1)):
        clip = raised(clip, off)
        retarget = build_retarget(skeleton, clip, up=None, reference="zero", unit=1.0, joints=())
        assert standing_height(retarget, clip) == pytest.approx(off, abs=1e-9)


def test_performers_without_standing_feet_give_no_floor(skeleton, make_clip):
    clip = make_clip(60)
    clip.values[:, 1] += 0.4 * np.abs(np.sin(0.9 * np.arange(60)))
    retarget = build_retarget(skeleton, clip, up=None, reference="zero", unit=1.0, joints=())
    assert standing_height(retarget, clip) is None
    bare = replace(skeleton, names=tuple(name.replace("Foot", "Hoof") for name in skeleton.names))
    retarget = build_retarget(bare, clip, up=None, reference="zero", unit=1.0, joints=())
    assert standing_height(retarget, clip) is None


@pytest.mark.parametrize("off", [-0.09, 0.05])
def test_hovering_clip_is_reported_and_corrected_on_request(skeleton, make_clip, off):
    clip = raised(walking(make_clip(60)), off)
    with pytest.warns(UserWarning, match=f'{abs(off)} m {"above" if off > 0 else "below"} its floor .*floor = "feet"'):
        reported = pose_at(skeleton, clip, 0.1, 1.0, PLAIN)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        asked, left = (pose_at(skeleton, clip, 0.1, 1.0, replace(PLAIN, floor=floor)) for floor in ("feet", "clip"))
    foot = skeleton.names.index("RightFoot")
    assert asked.transforms[foot, 1, 3] == pytest.approx(skeleton.rest[foot, 1, 3], abs=1e-9)
    np.testing.assert_array_equal(left.transforms, reported.transforms)
    np.testing.assert_allclose(reported.transforms[:, 1, 3] - asked.transforms[:, 1, 3], off, atol=1e-9)
    np.testing.assert_array_equal(asked.rates, reported.rates)


def test_a_single_pose_stands_on_its_feet(skeleton, make_clip):
    pose = pose_at(skeleton, raised(make_clip(1), -0.9), 0.0, 1.0, PLAIN)
    np.testing.assert_allclose(pose.transforms, skeleton.rest, atol=1e-9)


def test_real_clips_are_put_on_the_floor(shared):
    from hairpipe.formats.bvh import read_bvh
    from hairpipe.nodes.load_body import load_body

    folder = shared / "body_makehuman"
    rig = {"skeleton": folder / "default.mhskel", "weights": folder / "default_weights.mhw"}
    person = load_body(file=folder / "base.obj", group="body", unit=0.1, **rig).skeleton
    single = read_bvh(folder / "tpose.bvh")
    retarget = build_retarget(person, single, up=None, reference=None, unit=None, joints=())
    assert standing_height(retarget, single) == pytest.approx(-0.859, abs=0.01)
    feet = pose_at(person, single, 0.0, 1.0, PLAIN).transforms[[person.names.index(f"foot.{s}") for s in "LR"], 1, 3]
    rest = person.rest[[person.names.index(f"foot.{s}") for s in "LR"], 1, 3]
    np.testing.assert_allclose(feet, rest, atol=0.02)
