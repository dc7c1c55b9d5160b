"""People made for the tests of the body room."""

from collections.abc import Callable

import numpy as np
import pytest

from hairpipe.values import Skeleton
from hairpipe.values.body import Clip

ROTATIONS = ("Zrotation", "Xrotation", "Yrotation")
PERSON = {  # joint: parent, position [m]; a T pose
    "Hips": ("", (0.0, 0.9, 0.0)),
    "Spine": ("Hips", (0.0, 1.1, 0.0)),
    "Neck": ("Spine", (0.0, 1.45, 0.0)),
    "Head": ("Neck", (0.0, 1.55, 0.02)),
    "LeftArm": ("Spine", (0.18, 1.4, 0.0)),
    "LeftForeArm": ("LeftArm", (0.46, 1.4, 0.0)),
    "LeftHand": ("LeftForeArm", (0.72, 1.4, 0.0)),
    "RightArm": ("Spine", (-0.18, 1.4, 0.0)),
    "RightForeArm": ("RightArm", (-0.46, 1.4, 0.0)),
    "RightHand": ("RightForeArm", (-0.72, 1.4, 0.0)),
    "LeftUpLeg": ("Hips", (0.1, 0.85, 0.0)),
    "LeftLeg": ("LeftUpLeg", (0.1, 0.45, 0.0)),
    "LeftFoot": ("LeftLeg", (0.1, 0.05, 0.0)),
    "RightUpLeg": ("Hips", (-0.1, 0.85, 0.0)),
    "RightLeg": ("RightUpLeg", (-0.1, 0.45, 0.0)),
    "RightFoot": ("RightLeg", (-0.1, 0.05, 0.0)),
}
NAMES = tuple(PERSON)
PARENTS = np.array([NAMES.index(parent) if parent else -1 for parent, _ in PERSON.values()], np.int32)
PLACES = np.array([place for _, place in PERSON.values()])


def person_skeleton() -> Skeleton:
    rest = np.tile(np.eye(4), (len(NAMES), 1, 1))
    rest[:, :3, 3] = PLACES
    tips = PLACES.copy()
    tips[[NAMES.index("LeftFoot"), NAMES.index("RightFoot")], 1] = 0.0
    return Skeleton(NAMES, PARENTS, rest, tips)


def person_clip(frames: int, seed: int | None = None) -> Clip:
    """A person who stands still, or wriggles smoothly, on the spot where the hips are at rest."""
    offsets = np.where(PARENTS[:, None] < 0, 0.0, PLACES - PLACES[PARENTS])
    values = np.zeros((frames, 3 + 3 * len(NAMES)))
    values[:, :3] = PLACES[0]
    if seed is not None:
        chance = np.random.default_rng(seed)
        phases, sizes = chance.uniform(0.0, 6.0, values.shape[1]), chance.uniform(5.0, 40.0, values.shape[1])
        sizes[:3] = 0.1
        values += sizes * np.sin(phases + 0.15 * np.arange(frames)[:, None])
    channels = (("Xposition", "Yposition", "Zposition", *ROTATIONS),) + (ROTATIONS,) * (len(NAMES) - 1)
    ends = np.full_like(offsets, np.nan)
    ends[[NAMES.index("LeftFoot"), NAMES.index("RightFoot")]] = (0.0, -0.05, 0.0)
    return Clip(NAMES, PARENTS, offsets, ends, channels, values, 0.01)


@pytest.fixture
def skeleton() -> Skeleton:
    return person_skeleton()


@pytest.fixture
def make_clip() -> Callable[..., Clip]:
    return person_clip
