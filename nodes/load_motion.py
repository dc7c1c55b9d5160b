"""Motion capture on a body's skeleton."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.data import Body, Pose
from hairpipe.graph import Cuts, Time, node
from hairpipe.io.gltf.document import SUFFIXES as GLTF
from hairpipe.io.gltf.document import list_files
from hairpipe.units import Degrees, Ge, Gt, Metres, Reads, Seconds, Suffixes


@node(frames="each")
def load_motion(
    rest: Body,
    time: Time,
    cuts: Cuts,
    *,
    file: Annotated[Path, Suffixes((".bvh", *GLTF)), Reads(list_files)],
    clip: str | None = None,
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
    """Compute the pose of the body from a BVH clip of any skeleton, or from the glTF file of the body.

    A BVH clip is resampled to the frame rate and retargeted; `unit`, `up`, `reference`, `yaw`, `skip`, `floor` and
    `joints` are for BVH alone. The joints of a glTF file have the names of those of the body.

    file       path of the BVH clip or glTF file
    clip       name of an animation of a glTF file, or a pattern of names (*) to join some; by default the first
    at         frame of the shot at clip time `start`; the body is still outside the clip
    start      time in the clip at the frame `at`
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
    """
    from hairpipe.body.mocap.approach import approach
    from hairpipe.body.mocap.posing import Playback, pose_at
    from hairpipe.errors import BadInput
    from hairpipe.io.gltf.joints_of_skins import read_pose
    from hairpipe.io.mesh_cache.moving import Instant
    from hairpipe.io.mocap.bvh import recall_bvh

    def instant(frame: int) -> float:
        since = (frame - at) / time.fps
        return start + (max(since, 0.0) if settle > 0.0 else since) * speed

    since = (time.frame - at) / time.fps
    if file.suffix.lower() in GLTF:
        given = {"unit": unit, "up": up, "reference": reference, "yaw": yaw or None, "skip": skip, "floor": floor}
        if unused := [name for name, value in (given | {"joints": joints or None}).items() if value is not None]:
            raise BadInput(f"{unused[0]} is a setting of BVH clips", where=file, right=f"no {unused[0]}")
        played = tuple((instant(cut - 1) - start, instant(cut) - start) for cut in cuts)
        moment = Instant(start * time.fps, instant(time.frame) - start, played, fps=time.fps, speed=speed)
        pose = read_pose(file, rest.skeleton, clip, moment)
        return approach(rest.skeleton, pose, -since, settle) if settle > 0.0 > since else pose
    if clip is not None:
        raise BadInput("a BVH file has one clip", where="clip", right="no clip")
    sides = [(instant(cut - 1), instant(cut)) for cut in cuts]
    playback = Playback(up=up, reference=reference, unit=unit, skip=skip, joints=joints, floor=floor, yaw=yaw)
    pose = pose_at(rest.skeleton, recall_bvh(file), instant(time.frame), speed, playback, sides)
    return approach(rest.skeleton, pose, -since, settle) if settle > 0.0 > since else pose
