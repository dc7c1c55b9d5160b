"""The pose of a body at an instant of a clip, and how fast it changes; all times are in samples of the clip.

No motion goes on beyond the take of a clip that holds an instant: from cut to cut, or to an end of the clip.

A body moves from rest to the first pose of a shot, so that hair does not start inside it: every joint turns against
its parent, and a root in the world, on the smooth path

    L(t) = L_rest exp(h01(t / T) r) exp(g(t) w),   r = log(L_rest^T L_first),   g(t) = U h11(1 - (T - t) / U)

over T, with Hermite's h01 = 3 a^2 - 2 a^3 and h11 = a^3 - a^2; places likewise. The last factor is a run-up of U at
most, after which the joint has the velocity w that it begins the shot with: rest and first pose are met to the bit, and
the path is C1 at both.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hairpipe.body.performer import local_turns
from hairpipe.body.retarget import LOOKS, Retarget, build_retarget
from hairpipe.body.roles import Role, find_roles
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import exponential, invert, logarithm
from hairpipe.values import Body, Pose, Skeleton
from hairpipe.values.body import Clip

SLACK = 0.1  # by which an instant may be off its sample: files round their frame time, and shots are long


class Take(NamedTuple):
    """Samples of a clip between which a body moves without a jump."""

    first: int
    last: int  # included
    opens: bool  # whether a cut is before the first; else the clip begins there
    closes: bool  # whether a cut is after the last

    def window(self, at: float) -> tuple[tuple[float, float, float], float]:
        """Return three instants, of which the middle one is posed and the others give its rates, and their distance.

        The distance is 1, half to either side, less at an end of the take: rates are one-sided there. It is 0 where
        the body holds still: outside the clip. Up to a cut, no sample of the take may be left: motion goes on there as
        between its last two.
        """
        low = min(self.first, at) if self.opens else float(self.first)
        high = max(self.last, at) if self.closes else float(self.last)
        now = min(max(at, low), high)
        if abs(at - now) > SLACK or low == high:
            return (now, now, now), 0.0
        early = at - 0.5
        late = at + 0.5
        span = 1.0 - max(low - early, 0.0) - max(late - high, 0.0)
        return (max(early, low), now, min(late, high)), span


def take_at(count: int, at: float, cuts: Sequence[tuple[float, float]]) -> Take:
    """Return the take of a clip of so many samples that holds an instant; cuts are instants before and after each.

    Which of the samples between the two are before the cut is not known: none of them is used. Raises BadInput where a
    take has no sample.
    """
    starts = [math.ceil(after - SLACK) for _, after in cuts if after <= at]
    ends = [math.floor(before + SLACK) for before, after in cuts if after > at]
    first = max((start for start in starts if 0 < start < count), default=0)
    last = min((end for end in ends if 0 <= end < count - 1), default=count - 1)
    if first > last:
        what = f"the clip has no sample between the two cuts around its sample {at:.1f}"
        raise BadInput(what, where="cuts", right="one sample or more between two cuts")
    return Take(first, last, first > 0, last < count - 1)


RESTING = 0.25  # [m/s] slower than this, the lower foot stands


def standing_height(retarget: Retarget, clip: Clip) -> float | None:
    """Return the height of the feet above the floor of the body at rest [m], negative below it. Pure.

    That is the median of the lower foot's height over the frames in which it rests; None where the body has no feet, or
    they rest in less than a tenth of the frames.
    """
    skeleton = retarget.skeleton
    roles = find_roles(skeleton.names)
    feet = []  # masks of the joints of every foot, toes included
    for joint in [joint for side in ("left", "right") for joint in roles.get(Role("foot", side), [])]:
        below = np.zeros(len(skeleton.names), bool)
        below[joint] = True
        for child, parent in enumerate(skeleton.parents):
            below[child] |= parent >= 0 and below[parent]
        feet.append(below)
    if not feet:
        return None
    frames = np.unique(np.linspace(0.0, len(clip.values) - 1, LOOKS).round())
    step = min(1.0, len(clip.values) - 1.0)
    early = retarget.transforms(clip, np.minimum(frames, len(clip.values) - 1 - step))
    late = retarget.transforms(clip, np.minimum(frames + 1.0, len(clip.values) - 1.0))
    found = [soles(skeleton, foot, early, late, clip.frame_time) for foot in feet]
    heights, speeds = np.stack([height for height, _ in found]), np.stack([speed for _, speed in found])
    lower = heights.argmin(axis=0)[None]
    height, speed = (np.take_along_axis(rows, lower, axis=0)[0] for rows in (heights, speeds))
    rests = speed < RESTING
    return float(np.median(height[rests])) if rests.mean() >= 0.1 else None


def soles(
    skeleton: Skeleton, foot: np.ndarray, early: np.ndarray, late: np.ndarray, frame_time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the height of a foot over its place at rest [m] and the speed of its lowest point [m/s], (k,) each."""
    tips = np.concatenate([skeleton.tips, np.ones((len(skeleton.tips), 1))], axis=1)
    tips = np.einsum("jab,jb->ja", invert(skeleton.rest), tips)
    local = np.concatenate([np.tile([0.0, 0.0, 0.0, 1.0], (foot.sum(), 1)), tips[foot]])
    joints = np.tile(np.flatnonzero(foot), 2)
    here, there = (np.einsum("kjab,jb->kja", moves[:, joints], local)[..., :3] for moves in (early, late))
    rest = min(skeleton.rest[foot, 1, 3].min(), skeleton.tips[foot, 1].min())
    lowest = here[..., 1].argmin(axis=1)[:, None]
    speeds = np.linalg.norm(there - here, axis=2) / frame_time
    heights = np.take_along_axis(here[..., 1], lowest, axis=1) - rest
    return heights[:, 0], np.take_along_axis(speeds, lowest, axis=1)[:, 0]


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
    """Return the pose of a skeleton at an instant of a clip [s], counted from its first frame that is played. Pure.

    cuts  of the shot: the instants of the clip at the frames before and after each [s], ascending

    Rates are the central difference over one sampling interval of the clip about the instant, times `speed`: a pose
    depends on the samples within one and a half intervals of it (and on the first ones, see `leading_frames`), and on
    no others; on all of them with `floor` = "feet". At both ends of the clip and at cuts the difference is one-sided.
    Outside the clip its end poses are held. Raises BadInput where `skip` or two cuts leave no frame.
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
    """Return the distance by which to lower the clip so that its feet touch the body's floor [m], `floor` = "feet".

    A clip is left as it is by default, but for a single pose: otherwise its last frame could move the first. It is
    warned of instead, unless `floor` = "clip".
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
    """Return 1, with a warning, where the clip begins with a pose that is not part of the motion, else 0.

    That is where some joint turns by more than JUMP from the first frame to the second, and more than three times as
    much as any does from one to the next of the LOOKAHEAD frames after them.
    """
    count = min(LOOKAHEAD, len(clip.values)) - 1
    if count < 2:
        return 0
    turns = local_turns(clip, np.arange(count)).inv() * local_turns(clip, np.arange(count) + 1)
    steps = turns.magnitude().reshape(count, -1).max(axis=1)
    if steps[0] < JUMP or steps[0] < 3.0 * steps[1:].max():
        return 0
    message = f"the clip's first frame is {np.degrees(steps[0]):.0f} degrees away from the second: a T pose is assumed"
    warnings.warn(f"{message} and dropped (skip = 0 keeps it)", stacklevel=2)
    return 1


RUN_UP = 0.25  # longest time over which the velocity of the first pose is reached [s]
_INSTANT = 1e-4  # [s]; rates are differences over this time


def approach(rest: Body, first: Pose, before: float, over: float) -> Pose:
    """Return the pose so long before the first one [s], which is come to from rest over some time [s]. Pure."""
    times = [before + t for t in (_INSTANT, 0.0, -_INSTANT)]
    early, now, late = (placed(rest.skeleton, first, t, over) for t in times)
    rates = (late - early) / (2.0 * _INSTANT)
    if rest.shapes is None or first.weights is None or first.weight_rates is None:
        return Pose(now, rates)
    still = rest.shapes.rest
    way = first.weights - still
    past, present, future = (still + s * way + r * first.weight_rates for s, r in (shares(t, over) for t in times))
    return Pose(now, rates, present, (future - past) / (2.0 * _INSTANT))


def shares(before: float, over: float) -> tuple[float, float]:
    """Return the share of the way h01, and the run-up g [s], so long before the first pose [s]."""
    a = min(max(1.0 - before / over, 0.0), 1.0)
    up = min(RUN_UP, over)
    b = max(1.0 - before / up, 0.0)
    return a * a * (3.0 - 2.0 * a), up * b * b * (b - 1.0)


def placed(skeleton: Skeleton, first: Pose, before: float, over: float) -> np.ndarray:
    """Return the joint-to-world matrices of that pose [m], (J, 4, 4)."""
    share, run = shares(before, over)
    result = np.empty_like(first.transforms)
    for joint, parent in enumerate(skeleton.parents):
        rest, end, rate = skeleton.rest[joint], first.transforms[joint], first.rates[joint]
        if parent >= 0:
            back = invert(first.transforms[parent])
            rate = back @ (rate - first.rates[parent] @ back @ end)
            rest = invert(skeleton.rest[parent]) @ rest
            end = back @ end
        spin = end[:3, :3].T @ rate[:3, :3]
        turn = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
        local = np.eye(4)
        local[:3, :3] = rest[:3, :3] @ exponential(share * logarithm(rest[:3, :3].T @ end[:3, :3]))
        local[:3, :3] = local[:3, :3] @ exponential(run * turn)
        local[:3, 3] = rest[:3, 3] + share * (end[:3, 3] - rest[:3, 3]) + run * rate[:3, 3]
        result[joint] = result[parent] @ local if parent >= 0 else local
    return result
