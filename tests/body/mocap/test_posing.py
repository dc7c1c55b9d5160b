"""Poses of a clip at an instant: rates, cuts, frames that are skipped, and feet on the floor."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.bust import build_skeleton
from hairpipe.body.posing import Playback, leading_frames, pose_at, standing_height
from hairpipe.body.retarget import build_retarget
from hairpipe.errors import BadInput
from hairpipe.formats.bvh import read_bvh

PLAIN = Playback(up=None, reference=None, unit=None, skip=None, joints=())


def spin_of(pose, joint: int) -> np.ndarray:
    """Angular velocity [rad/s] from W = dR/dt R^T."""
    w = pose.rates[joint, :3, :3] @ pose.transforms[joint, :3, :3].T
    return 0.5 * np.array([w[2, 1] - w[1, 2], w[0, 2] - w[2, 0], w[1, 0] - w[0, 1]])


@pytest.mark.parametrize("speed", [1.0, 0.5, 3.0])
def test_rates_are_the_change_over_one_sampling_interval(skeleton, make_clip, speed):
    clip = make_clip(20, seed=1)
    pose = pose_at(skeleton, clip, 0.0731, speed, PLAIN)
    half = 0.5 * clip.frame_time
    around = [pose_at(skeleton, clip, 0.0731 + step, speed, PLAIN).transforms for step in (-half, half)]
    np.testing.assert_allclose(pose.rates, speed * (around[1] - around[0]) / (2.0 * half), atol=1e-9)


def test_rates_approach_the_true_derivative_of_smooth_motion(skeleton, make_clip):
    clip = make_clip(200, seed=2)
    step = 1e-4
    pose = pose_at(skeleton, clip, 0.755, 1.0, PLAIN)  # between two samples: the clip is smooth there
    before, after = (pose_at(skeleton, clip, 0.755 + s, 1.0, PLAIN).transforms for s in (-step, step))
    np.testing.assert_allclose(pose.rates, (after - before) / (2.0 * step), atol=0.05 * np.abs(pose.rates).max())


@pytest.mark.filterwarnings("ignore:where the clip's feet")
def test_a_tail_edit_leaves_earlier_poses_unchanged(skeleton, make_clip):
    clip = make_clip(60, seed=3)
    values = clip.values.copy()
    values[40:] = 0.0
    edited = replace(clip, values=values[:55])
    for seconds in (0.0, 0.1234, 0.385, 0.39 - 1e-9):
        before, after = pose_at(skeleton, clip, seconds, 1.0, PLAIN), pose_at(skeleton, edited, seconds, 1.0, PLAIN)
        assert before.transforms.tobytes() == after.transforms.tobytes()
        if seconds < 0.385:
            assert before.rates.tobytes() == after.rates.tobytes()
    assert (
        pose_at(skeleton, clip, 0.41, 1.0, PLAIN).transforms != pose_at(skeleton, edited, 0.41, 1.0, PLAIN).transforms
    ).any()


@pytest.mark.filterwarnings("ignore:the shot begins before")
@pytest.mark.parametrize(("seconds", "frame"), [(-1.0, 0), (-0.006, 0), (0.096, 9), (5.0, 9)])
def test_outside_the_clip_the_body_holds_still(skeleton, make_clip, seconds, frame):
    clip = make_clip(10, seed=4)
    pose = pose_at(skeleton, clip, seconds, 1.0, PLAIN)
    end = pose_at(skeleton, clip, frame * clip.frame_time, 1.0, PLAIN)
    np.testing.assert_allclose(pose.transforms, end.transforms, atol=1e-12)
    np.testing.assert_array_equal(pose.rates, 0.0)


def running(clip, frame_time: float, leap: int | None = None):
    """A person who runs along X at 5 m/s, and is somewhere else from one sample on; channels in metres."""
    values = clip.values.copy()
    values[:, 0] += 5.0 * frame_time * np.arange(len(values))
    values[leap or len(values) :, 0] += 40.0
    return replace(clip, values=values, frame_time=frame_time)


@pytest.mark.parametrize("seconds", [0.0, 0.02, 0.26, 0.29])
def test_a_clip_that_begins_and_ends_in_motion_has_its_whole_velocity_there(skeleton, make_clip, seconds):
    pose = pose_at(skeleton, running(make_clip(30), 0.01), seconds, 1.0, replace(PLAIN, unit=1.0))
    assert pose.rates[:, 0, 3] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("fps", "frame_time", "first"),  # first frame after the cut, as a sample or between two of them
    [(24.0, 1 / 24, 12.0), (24.0, 0.0416667, 12.0), (24.0, 1 / 120, 60.0), (24.0, 1 / 30, 15.0), (60.0, 1 / 24, 4.8)],
)
def test_at_a_cut_poses_and_velocities_are_those_of_one_side(skeleton, make_clip, fps, frame_time, first):
    clip = running(make_clip(200), frame_time, leap=int(np.ceil(first)))
    frame = round(first * frame_time * fps)
    cuts = [((frame - 1) / fps, frame / fps)]
    there = pose_at(skeleton, clip, 0.0, 1.0, replace(PLAIN, unit=1.0)).transforms[0, 0, 3]
    for now in range(frame - 4, frame + 4):
        pose = pose_at(skeleton, clip, now / fps, 1.0, replace(PLAIN, unit=1.0), cuts)
        assert pose.rates[:, 0, 3] == pytest.approx(5.0)
        assert pose.transforms[0, 0, 3] - there == pytest.approx(5.0 * now / fps + 40.0 * (now >= frame))


def test_a_cut_changes_no_pose_that_is_far_from_it(skeleton, make_clip):
    clip, cuts = make_clip(60, seed=3), [(0.29, 0.3)]
    for sample in (0, 10, 28, 31, 45):
        one, other = (pose_at(skeleton, clip, 0.01 * sample, 1.0, PLAIN, some) for some in ((), cuts))
        assert one.transforms.tobytes() == other.transforms.tobytes() and one.rates.tobytes() == other.rates.tobytes()


def test_takes_without_a_sample_are_refused(skeleton, make_clip):
    with pytest.raises(BadInput, match=r"no sample between the two cuts around its sample 4\.4"):
        pose_at(skeleton, make_clip(20), 0.044, 1.0, PLAIN, [(0.041, 0.043), (0.046, 0.048)])


def test_shot_before_the_clip_is_reported(skeleton, make_clip):
    with pytest.warns(UserWarning, match="before the clip"):
        pose_at(skeleton, make_clip(3), -1.0, 1.0, PLAIN)


def with_t_pose(clip):
    values = np.concatenate([np.zeros((1, clip.values.shape[1])), clip.values + 25.0])
    return replace(clip, values=values)


def test_a_leading_t_pose_is_dropped_with_a_word(skeleton, make_clip):
    clip = with_t_pose(make_clip(30, seed=5))
    with pytest.warns(UserWarning, match="T pose.*skip = 0"):
        dropped = pose_at(skeleton, clip, 0.0, 1.0, PLAIN)
    reported = pose_at(skeleton, clip, 0.0, 1.0, replace(PLAIN, skip=1))
    kept = pose_at(skeleton, clip, clip.frame_time, 1.0, replace(PLAIN, skip=0))
    np.testing.assert_array_equal(dropped.transforms, reported.transforms)
    np.testing.assert_allclose(dropped.transforms, kept.transforms, atol=1e-12)


@pytest.mark.parametrize("frames", [1, 2, 3, 30])
def test_smooth_beginnings_are_kept(make_clip, frames):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert leading_frames(make_clip(frames, seed=6)) == 0


def test_skipping_everything_is_refused(skeleton, make_clip):
    with pytest.raises(BadInput, match="skip = 3 leaves none of the 3"):
        pose_at(skeleton, make_clip(3), 0.0, 1.0, replace(PLAIN, skip=3))


# Largest turn of the head over a window of 1/30 s, as measured by an independent reader on the same files.
CLIPS = {
    "cmu_05_06": 974.0,
    "cmu_49_08": 403.0,
    "cmu_61_12_scaled": 2539.0,
    "fair1_dab": 616.0,
    "rokoko_jesse_dance": 98.0,
}


@pytest.mark.parametrize("name", CLIPS)
def test_the_head_of_our_bust_turns_as_fast_as_the_performers(shared, name):
    clip = read_bvh(shared / "mocap" / f"{name}.bvh")
    played = replace(clip, values=clip.values[1:])
    retarget = build_retarget(build_skeleton(), clip, up=None, reference=None, unit=None, joints=())
    head = retarget.transforms(played, np.arange(len(played.values)))[:, -1]
    window = max(round(1.0 / 30.0 / clip.frame_time), 1)
    turns = Rotation.from_matrix(head[:, :3, :3])
    speed = (turns[:-window].inv() * turns[window:]).magnitude().max() / (window * clip.frame_time)
    assert np.degrees(speed) == pytest.approx(CLIPS[name], rel=0.02)
    assert (
        np.linalg.norm(np.diff(head[:, :3, 3], axis=0), axis=1).max() / clip.frame_time < 5.0
    )  # [m/s], at the declared rate


def test_our_own_clip_shakes_the_head_hard_and_comes_to_rest():
    clip = read_bvh(Path(__file__).resolve().parents[3] / "graphs" / "assets" / "shake.bvh")
    skeleton = build_skeleton()
    poses = [pose_at(skeleton, clip, frame / 24.0, 1.0, PLAIN) for frame in range(60)]
    spin = np.degrees([np.linalg.norm(spin_of(pose, -1)) for pose in poses])
    assert spin[:5].max() == 0.0
    assert 550.0 < spin.max() < 700.0
    assert spin[-1] < 60.0
    np.testing.assert_allclose(poses[0].transforms, skeleton.rest, atol=1e-9)


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
