"""Motion capture on a body's skeleton."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.engine import Cuts, First, Time, node
from hairpipe.formats.registry import list_files, suffixes_of
from hairpipe.plain_file import Absent
from hairpipe.units import Degrees, Ge, Gt, Metres, Reads, Seconds, Suffixes
from hairpipe.values import Body, Pose


@node(frames="each")
def load_motion(
    rest: Body,
    time: Time,
    cuts: Cuts,
    first: First = First(1001),  # noqa: B008 - a number
    *,
    file: Annotated[Path, Suffixes(suffixes_of("motion")), Reads(list_files)],
    clip: str | None = None,
    group: str | None = None,
    at: int | None = None,
    start: Seconds | None = None,
    settle: Annotated[Seconds, Ge(0.0)] = 0.0,
    speed: Annotated[float, Gt(0)] = 1.0,
    unit: Annotated[Metres, Gt(0)] | None = None,
    up: Literal["y", "z"] | None = None,
    reference: Literal["zero", "first"] | None = None,
    yaw: Degrees = 0.0,
    skip: Annotated[int, Ge(0)] | None = None,
    floor: Literal["clip", "feet"] | None = None,
    joints: tuple[tuple[str, str], ...] = (),
    absent: Absent = "refuse",
) -> Pose:
    """Compute the pose of the body from a BVH clip, or from the joints of a glTF or UsdSkel file.

    The pose of the body of a glTF or USD file is that of the file. A BVH clip is resampled to the frame rate and
    retargeted, and so is a file whose joints at rest are not those of the body, or any with one of the settings `unit`,
    `up`, `reference`, `yaw`, `skip`, `floor` and `joints`. Weights of blend shapes and morph targets go by name.

    file       path of the BVH clip, glTF or USD file
    clip       name of an animation of a glTF file, or a pattern of names (*) to join some; by default the first take
    group      path of the meshes of a USD file, or name of a node of a glTF file, whose joints are read
    at         frame of the shot at clip time `start`, by default 1001; the body is still outside the clip
    start      time in the clip at the frame `at`; a clip of USD or glTF begins at its first sample. By default 0, but
               without `at` a USD or glTF file that reaches the frames of the shot keeps its times
    settle     duration before `at` in which the body moves from rest to its first pose; see `preroll` of a graph
    speed      playback speed: 0.5 is half the recorded speed
    unit       metres per unit of the clip; by default the ratio of leg lengths, or 1 without legs
    up         vertical axis of the clip; by default inferred from the trunk over the whole clip
    reference  pose of the clip that equals the body at rest: zero in all channels, or the first frame
    yaw        rotation of the whole motion about Y; 180 reverses its direction
    skip       number of frames to drop at the beginning; by default that of a detected T pose
    floor      vertical placement: clip keeps that of the clip, feet puts resting feet on the floor of the body (fitted
               to the whole clip, so that an edit of its end may move all frames); by default feet for a single pose,
               else clip with a warning
    joints     pairs of joint names of the body and of the clip, if names differ
    absent     treatment of absent files that a USD stage names: refuse, or warn and read the rest
    """
    from hairpipe.body.posing import Playback, approach, pose_at
    from hairpipe.formats.animated_meshes import AT, Instant
    from hairpipe.formats.bvh import recall_bvh
    from hairpipe.formats.registry import recall_joints
    from hairpipe.formats.rigging import clip_of, pose_of, sample_pose, start_of, weighted

    def elapsed(frame: int) -> float:
        since = (frame - anchor) / time.fps
        return (max(since, 0.0) if settle > 0.0 else since) * speed

    anchor, reach = (AT, first) if at is None else (at, None)
    since = (time.frame - anchor) / time.fps
    sides = tuple((elapsed(cut - 1), elapsed(cut)) for cut in cuts)
    playback = Playback(up=up, reference=reference, unit=unit, skip=skip, joints=joints, floor=floor, yaw=yaw)
    motion = recall_joints(file, group, clip, time.fps, absent)
    moment = Instant(start, elapsed(time.frame), sides, anchor, reach, fps=time.fps, speed=speed)
    sampled = sample_pose(motion, moment) if motion and (motion.shapes or playback == Playback()) else None
    pose = pose_of(motion, rest.skeleton, sampled) if motion and sampled and playback == Playback() else None
    if pose is None:
        begin, played = (start_of(motion, moment), clip_of(motion)) if motion else (start or 0.0, recall_bvh(file))
        begun = [(begin + before, begin + after) for before, after in sides]
        pose = pose_at(rest.skeleton, played, begin + elapsed(time.frame), speed, playback, begun)
    pose = weighted(pose, motion.shapes, sampled, rest.shapes) if motion and sampled else pose
    return approach(rest, pose, -since, settle) if settle > 0.0 > since else pose
