"""The pose of a body at an instant of a clip, and how fast it changes."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hairpipe.body.mocap.floor import standing_height
from hairpipe.body.mocap.performer import local_turns
from hairpipe.body.mocap.retarget import Retarget, build_retarget
from hairpipe.body.mocap.take import take_at
from hairpipe.data import Pose, Skeleton
from hairpipe.data.clip import Clip
from hairpipe.errors import BadInput

LOOKAHEAD = 10  # frames at the head of a clip that a leading T pose is judged by
HOVER = 0.02  # [m] that feet may be off the floor without a word; soles are a centimetre or two below the bones
JUMP = np.radians(20.0)  # smallest turn of a joint from one frame to the next that can be the end of a T pose


@dataclass(frozen=True)
class Playback:
    """Settings of the reading of a clip, see node load_motion."""

    up: str | None = None
    reference: str | None = None
    unit: float | None = None
    skip: int | None = None
    joints: tuple[tuple[str, str], ...] = ()
    floor: str | None = None
    yaw: float = 0.0


def pose_at(
    skeleton: Skeleton,
    clip: Clip,
    seconds: float,
    speed: float,
    playback: Playback,
    cuts: Sequence[tuple[float, float]] = (),
) -> Pose:
    """Return the pose of a skeleton at an instant of a clip, counted from its first frame that is played. Pure.

    cuts  of the shot: the instants of the clip at the frames before and after each [s], ascending

    Rates are the central difference over one sampling interval of the clip about the instant, times `speed`: a pose
    depends on the samples within one and a half intervals of it, that is on two to either side at most (and on the
    first ones, see `leading_frames`), and on no others; on all of them with `floor` = "feet". At both ends of the clip
    and at cuts the difference is one-sided, see `Take`.
    Outside the clip its end poses are held. Raises BadInput where `skip` leaves no frame, or cuts leave none between
    two.
    """
    read = {name: getattr(playback, name) for name in ("up", "reference", "unit", "joints", "yaw")}
    retarget = build_retarget(skeleton, clip, **read)
    skip = leading_frames(clip) if playback.skip is None else playback.skip
    if skip >= len(clip.values):
        raise BadInput(f"skip = {skip} leaves none of the {len(clip.values)} frames", where="skip", right="less")
    played = replace(clip, values=clip.values[skip:])
    if seconds < 0.0:
        warnings.warn(
            "the shot begins before the clip; the first pose of the clip is held until then (see `at`)", stacklevel=2
        )
    at = seconds / clip.frame_time
    frame_time = clip.frame_time
    take = take_at(len(played.values), at, [(before / frame_time, after / frame_time) for before, after in cuts])
    instants, span = take.window(at)
    samples = replace(played, values=played.values[take.first : take.last + 1])
    before, now, after = retarget.transforms(samples, np.array(instants) - take.first)
    now[:, 1, 3] -= lift(retarget, played, playback.floor)
    return Pose(now, (after - before) * (speed / frame_time / span) if span > 0.0 else np.zeros_like(now))


def lift(retarget: Retarget, clip: Clip, floor: str | None) -> float:
    """Return the distance by which to lower the clip so that its feet touch the body's floor [m]; pure.

    floor  "clip": not at all; "feet": by all of what `standing_height` says; None: so for a single pose

    A clip is left as it is by default: otherwise its last frame could move the first. It is warned of instead.
    """
    height = standing_height(retarget, clip) if floor != "clip" else None
    if height is None:
        return 0.0
    if floor == "feet" or len(clip.values) == 1:
        return height
    if abs(height) > HOVER:
        where = "above" if height > 0.0 else "below"
        message = f"where the clip's feet rest, those of the body are {abs(height):.2g} m {where} its floor"
        warnings.warn(f'{message} (floor = "feet" moves them to the floor, "clip" silences this warning)', stacklevel=2)
    return 0.0


def leading_frames(clip: Clip) -> int:
    """Return 1 where the clip begins with a pose that is not part of the motion, else 0; warns if so. Pure.

    That is where some joint turns by more than JUMP from the first frame to the second, and more than three times as
    much as any does from one to the next of the LOOKAHEAD frames after them.
    """
    head = local_turns(clip, np.arange(min(LOOKAHEAD, len(clip.values))))
    if len(head) < 3:
        return 0
    cosines = np.abs(np.einsum("fji,fji->fj", head[1:], head[:-1]))
    steps = 2.0 * np.arccos(np.minimum(cosines, 1.0)).max(axis=1)
    if steps[0] < JUMP or steps[0] < 3.0 * steps[1:].max():
        return 0
    message = f"the clip's first frame is {np.degrees(steps[0]):.0f} degrees away from the second: a T pose is assumed"
    warnings.warn(f"{message} and dropped (skip = 0 keeps it)", stacklevel=2)
    return 1
