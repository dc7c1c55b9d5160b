"""What a joint is in a human body, read from its name in any of the usual conventions."""

import re
from typing import NamedTuple

import numpy as np


class Role(NamedTuple):
    """A part of the body and its side, "" in the middle, "left" or "right"."""

    part: str
    side: str = ""


# Names with sides, digits, case and punctuation taken away; the earlier of two names of one part is preferred.
# CMU and Rokoko say Shoulder for the collar bone, Daz and others for the upper arm: arms are looked for first.
CENTRE = {
    "head": ("head",),
    "neck": ("neck", "lowerneck", "upperneck", "necklower", "neckupper"),
    "spine": (
        *("spine", "abdomen", "abdomenlower", "abdomenupper", "lowerback", "upperback", "back", "waist", "torso"),
        *("chest", "chestlower", "chestupper", "lowerchest", "upperchest", "thorax"),
    ),
    "hips": ("hips", "hip", "pelvis", "root"),
}
SIDED = {
    "upperarm": ("arm", "uparm", "upperarm", "shldr", "shldrbend", "humerus", "shoulder"),
    "clavicle": ("clavicle", "collar", "collarbone", "shoulder"),
    "forearm": ("forearm", "lowerarm", "loarm", "forearmbend", "radius", "elbow"),
    "hand": ("hand", "wrist"),
    "thigh": ("upleg", "upperleg", "thigh", "thighbend", "femur", "hip"),
    "shin": ("leg", "lowerleg", "loleg", "shin", "calf", "tibia", "knee"),
    "foot": ("foot", "ankle"),
}
CHAINS = ("spine", "neck")  # parts that several joints in a row may play
SIDES = {"l": "left", "left": "left", "r": "right", "right": "right"}
PREFIXES = {"bip", "character", "def", "jnt"}


def find_roles(names: tuple[str, ...]) -> dict[Role, list[int]]:
    """Return the joints that play every part found, in the order of the skeleton; one joint but for chains. Pure."""
    plain = [plain_name(name) for name in names]
    roles: dict[Role, list[int]] = {}
    taken: set[int] = set()
    for part, side, synonyms in _parts():
        found = [joint for word in synonyms for joint, name in enumerate(plain) if name == (word, side)]
        found = sorted(found) if part in CHAINS else [joint for joint in found if joint not in taken][:1]
        if found:
            roles[Role(part, side)] = found
            taken.update(found)
    return roles


def _parts() -> list[tuple[str, str, tuple[str, ...]]]:
    middle = [(part, "", synonyms) for part, synonyms in CENTRE.items()]
    return middle + [(part, side, synonyms) for side in ("left", "right") for part, synonyms in SIDED.items()]


def plain_name(name: str) -> tuple[str, str]:
    """Return the bare lower-case name of a joint and its side. Pure."""
    words = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", re.split(r"[:|]", name)[-1])
    words = [word.lower() for word in words if word.lower() not in PREFIXES]
    side = next((SIDES[word] for word in words if word in SIDES), "")
    return "".join(word for word in words if word not in SIDES), side


def match_roles(body: dict[Role, list[int]], clip: dict[Role, list[int]]) -> dict[int, int]:
    """Return the clip joint that every body joint follows, for the parts that both have. Pure.

    Chains of different length are spread over one another; where one of them has no hips to begin at they are
    aligned at the top, so that the chest of a bust follows the highest joint of the performer's spine.
    """
    pairs: dict[int, int] = {}
    whole = Role("hips") in body and Role("hips") in clip
    for role, joints in body.items():
        others = clip.get(role, [])
        if others and role.part == "spine" and not whole:
            pairs.update(zip(joints[::-1], others[::-1], strict=False))
        elif others:
            pairs.update(zip(joints, spread(others, len(joints)), strict=True))
    return pairs


def spread(chain: list[int], count: int) -> list[int]:
    """Return `count` joints of a chain, evenly from its first to its last; the last alone for 1. Pure."""
    if count == 1:
        return chain[-1:]
    places = np.rint(np.linspace(0.0, len(chain) - 1.0, count)).astype(int)
    return [chain[place] for place in places]
