"""Motion capture on a body's skeleton."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.data import Body, Pose
from hairpipe.graph import Cuts, Time, node
from hairpipe.units import Degrees, Ge, Gt, Metres, Seconds, Suffixes


@node(frames="each")
def load_motion(
    rest: Body,
    time: Time,
    cuts: Cuts,
    *,
    file: Annotated[Path, Suffixes((".bvh",))],
    at: int = 1001,
    start: Seconds = 0.0,
    settle: Annotated[Seconds, Ge(0.0)] = 0.0,
    speed: Annotated[float, Gt(0)] = 1.0,
    unit: Annotated[Metres, Gt(0)] | None = None,
    up: Literal["y", "z"] | None = None,
    reference: Literal["zero", "first"] | None = None,
    yaw: Degrees = 0.0,
    skip: Annotated[int, Ge(0)] | None = None,
    floor: Literal["clip", "feet"] | None = None,
    joints: tuple[tuple[str, str], ...] = (),
) -> Pose:
    """The pose of the body at a frame, from a BVH clip of any skeleton, resampled to the frame rate.

    file       the clip
    at         frame of the shot at which the clip is at `start`; outside the clip the body holds still
    start      where in the clip it is then
    settle     before `at` the body comes from rest to its pose there, so long; see `preroll` of a graph
    speed      of playing: 0.5 is half as fast as recorded
    unit       metres in one unit of the clip; if not given legs are scaled to the body's, or 1 where they do not tell
    up         axis of the clip that points up; inferred from the trunk over the whole clip if not given
    reference  pose of the clip that stands for the body at rest: zero in all channels, or its first frame
    yaw        turn of the whole motion about Y: 180 if the body is to face the other way
    skip       frames to drop at the beginning; a T pose is recognised and dropped if not given
    floor      clip: its own; feet: lowered until feet that rest stand on the body's, by a look at the whole clip, an
               edit of whose tail may move all frames; by default feet for a single pose, else clip with a warning
    joints     pairs of a joint of the body and the joint of the clip it follows, where their names do not match
    """
    from hairpipe.body.mocap.approach import approach
    from hairpipe.body.mocap.posing import Playback, pose_at
    from hairpipe.io.mocap.bvh import recall_bvh

    def instant(frame: int) -> float:
        since = (frame - at) / time.fps
        return start + (max(since, 0.0) if settle > 0.0 else since) * speed

    since = (time.frame - at) / time.fps
    sides = [(instant(cut - 1), instant(cut)) for cut in cuts]
    playback = Playback(up=up, reference=reference, unit=unit, skip=skip, joints=joints, floor=floor, yaw=yaw)
    pose = pose_at(rest.skeleton, recall_bvh(file), instant(time.frame), speed, playback, sides)
    return approach(rest.skeleton, pose, -since, settle) if settle > 0.0 > since else pose
