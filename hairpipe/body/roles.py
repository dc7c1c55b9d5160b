"""Role of a joint in a human body, read from its name in any of the usual conventions."""

import re
from collections import Counter
from typing import NamedTuple

import numpy as np


class Role(NamedTuple):
    """A part of the body and its side, "" in the middle, "left" or "right"."""

    part: str
    side: str = ""


# Names with sides, digits, case and punctuation taken away; the earlier of two names of one part is preferred.
# CMU and Rokoko say Shoulder for the collar bone, Daz and others for the upper arm: arms are looked for first.
# SMPL and Kinect have both Ankle and Foot, Wrist and Hand: the former is the joint that the limb ends at.
CENTRE = {
    "head": ("head",),
    "neck": ("neck", "lowerneck", "upperneck", "necklower", "neckupper", "necktwist"),
    "spine": (
        *("spine", "abdomen", "abdomenlower", "abdomenupper", "lowerback", "upperback", "back", "waist", "torso"),
        *("chest", "chestlower", "chestupper", "lowerchest", "upperchest", "thorax", "spinemid", "spineshoulder"),
    ),
    "hips": ("hips", "hip", "pelvis", "spinebase", "hipcenter", "root"),
}
SIDED = {
    "upperarm": ("arm", "uparm", "upperarm", "shldr", "shldrbend", "humerus", "shoulder"),
    "clavicle": ("clavicle", "clav", "collar", "collarbone", "scapula", "shoulder"),
    "forearm": ("forearm", "lowerarm", "loarm", "forearmbend", "radius", "elbow"),
    "hand": ("wrist", "hand"),
    "thigh": ("upleg", "upperleg", "thigh", "thighbend", "femur", "hip"),
    "shin": ("leg", "lowerleg", "loleg", "shin", "calf", "tibia", "knee"),
    "foot": ("ankle", "foot"),
}
CHAINS = ("spine", "neck")  # parts that several joints in a row may play
SIDES = {
    **{word: "left" for word in ("l", "left", "lft")},
    **{word: "right" for word in ("r", "right", "rgt", "rt")},
    **{word: "" for word in ("c", "m")},  # VRM and others: in the middle
}
PREFIXES = {"bip", "character", "def", "jnt", "mixamorig"}
SIDED_WORDS = {word for words in SIDED.values() for word in words}
KNOWN = {*SIDES, *SIDED_WORDS, *(word for words in CENTRE.values() for word in words)}
GLUED = re.compile(r"(left|right|l|r)(\w+)")  # a side in front of a part, without a gap: lfemur, rightarm
VERTEBRA = re.compile(r"([clt])\d+", re.IGNORECASE)  # of the neck, the chest, the loins: Xsens
COMMON = 0.6  # share of the names that begin with a word, from which it is the name of the character


def find_roles(names: tuple[str, ...]) -> dict[Role, list[int]]:
    """Return the joints that play every part found, in the order of the skeleton; one joint but for chains. Pure."""
    plain = plain_names(names)
    roles: dict[Role, list[int]] = {}
    taken: set[int] = set()
    parts = [(part, "", synonyms) for part, synonyms in CENTRE.items()]
    parts += [(part, side, synonyms) for side in ("left", "right") for part, synonyms in SIDED.items()]
    for part, side, synonyms in parts:
        found = [joint for word in synonyms for joint, name in enumerate(plain) if name == (word, side)]
        found = sorted(found) if part in CHAINS else [joint for joint in found if joint not in taken][:1]
        if found:
            roles[Role(part, side)] = found
            taken.update(found)
    return roles


def plain_names(names: tuple[str, ...]) -> list[tuple[str, str]]:
    """Return the bare lower-case name and the side of every joint, without a word that most names begin or end with.

    That is the name of the character, or a word for a joint.
    """
    last_parts = [re.split(r"[:|]", name)[-1] for name in names]
    words = [[word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", part)] for part in last_parts]
    for end in (0, -1):
        while common := _common_word(words, end):
            words = [some[1 + end : len(some) + end] if some[end:][:1] == [common] else some for some in words]
    vertebrae = [VERTEBRA.fullmatch(name) for name in names]
    return [
        (("neck" if found[1].lower() == "c" else "spine"), "") if found else plain_words(some)
        for found, some in zip(vertebrae, words, strict=True)
    ]


def _common_word(words: list[list[str]], end: int) -> str | None:
    """Return the word that most of these begin with, or end with, in front of or behind others; None without one."""
    found = Counter(some[end] for some in words if len(some) > 1 and some[end] not in KNOWN)
    word, count = max(found.items(), key=lambda item: item[1], default=("", 0))
    return word if count > COMMON * len(words) else None


def plain_words(words: list[str]) -> tuple[str, str]:
    words = [word for word in words if word not in PREFIXES]
    side = next((SIDES[word] for word in words if SIDES.get(word)), "")
    plain = "".join(word for word in words if word not in SIDES)
    glued = GLUED.fullmatch(plain)
    if glued and not side and glued[2] in SIDED_WORDS:
        return glued[2], SIDES[glued[1]]
    return plain, side


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
