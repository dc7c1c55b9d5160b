"""Biovision hierarchy files (.bvh): motion capture as text.

Alone among the formats of others they are read in this process: no library parses them that could crash, and to start
a child takes .2 to .3 s, where a clip of 60 kB takes .01 s. Memory and time are bounded by the size of the text,
`hairpipe.io.text.MOST_BYTES`, and of its hierarchy, MOST_LETTERS and MOST_JOINTS: the largest file takes 4 s and .9 GB.
"""

import re
import warnings
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from hairpipe.data.clip import Clip
from hairpipe.errors import BadInput
from hairpipe.io.mocap.bvh_hierarchy import MOST_JOINTS, MOST_LETTERS, Hierarchy, tokenise
from hairpipe.io.text import LARGEST, parse_number, parse_numbers, read_text

BLANKS = b" \t\v\f"


def recall_bvh(path: Path) -> Clip:
    """Read a clip once per process, as long as the file's size and time are unchanged."""
    try:
        status = path.stat()
    except OSError:
        return read_bvh(path)
    return _recall(path, status.st_size, status.st_mtime_ns)


@lru_cache(maxsize=8)
def _recall(path: Path, size: int, modified: int) -> Clip:
    return read_bvh(path)


def read_bvh(path: Path) -> Clip:
    """Read a clip with any order of channels and any names of joints.

    Raises BadInput, with the line, where the file cannot be read or does not follow the format.
    """
    lines = read_text(path).splitlines()
    motion = next((i for i, line in enumerate(lines) if line.strip().upper() == "MOTION"), None)
    if motion is None:
        raise BadInput("there is no MOTION section", where=path, right="a BVH file: HIERARCHY, then MOTION")
    letters = sum(map(len, lines[:motion]))
    if letters > MOST_LETTERS:
        right = f"at most {MOST_LETTERS:,}, for at most {MOST_JOINTS:,} joints"
        raise BadInput(f"the HIERARCHY section has {letters:,} letters", where=path, right=right)
    hierarchy = Hierarchy(path, tokenise(lines[:motion]))
    hierarchy.read()
    frames, frame_time, first = _read_counts(path, lines, motion + 1)
    channels = tuple(tuple(joint.channels) for joint in hierarchy.joints)
    values = _read_values(path, lines, first, frames, sum(map(len, channels)))
    _put_in_place(hierarchy, values)
    return Clip(
        names=tuple(joint.name for joint in hierarchy.joints),
        parents=np.array([joint.parent for joint in hierarchy.joints], np.int32),
        offsets=np.array([joint.offset for joint in hierarchy.joints]),
        ends=np.array([joint.end for joint in hierarchy.joints]),
        channels=channels,
        values=values,
        frame_time=frame_time,
    )


def _read_counts(path: Path, lines: list[str], start: int) -> tuple[int, float, int]:
    """The number of frames, the frame time [s] and the index of the first line of values."""
    found = []
    patterns = (r"frames\s*:?\s*(\S+)", r"frame\s*time\s*:?\s*(\S+)")
    named = iter(zip(patterns, ("Frames: 120", "Frame Time: 0.00833333"), strict=True))
    for index, line in _filled(lines, start):
        if (expected := next(named, None)) is None:
            break
        match = re.fullmatch(expected[0], line.strip(), re.IGNORECASE)
        value = parse_number(match[1]) if match else None
        if value is None or value <= 0.0:
            raise BadInput(
                f"{line.strip()[:60]!r} is not understood", where=f"{path}, line {index + 1}", right=expected[1]
            )
        found.append(value)
    else:
        index = len(lines)
    if len(found) < 2 or found[0] != int(found[0]):
        raise BadInput("the counts of the MOTION section are missing", where=path, right="Frames: and Frame Time:")
    return int(found[0]), found[1], index


def _filled(lines: list[str], start: int) -> Iterator[tuple[int, str]]:
    return ((index, lines[index]) for index in range(start, len(lines)) if lines[index].strip())


def _read_values(path: Path, lines: list[str], first: int, frames: int, width: int) -> np.ndarray:
    """The channel values (frames, width); a frame may be broken over several lines."""
    text = " ".join(lines[first:]).encode()
    is_blank = np.append(True, np.isin(np.frombuffer(text, np.uint8), np.frombuffer(BLANKS, np.uint8)))
    values = parse_numbers(text, np.count_nonzero(is_blank[:-1] & ~is_blank[1:]))
    if values is None or not (np.abs(values) <= LARGEST).all():
        raise _bad_word(path, lines, first)
    if len(values) > frames * width and len(values) % width == 0:
        extra = len(values) // width - frames
        message = f"{path}: the file has {frames + extra} frames, its header states {frames}: the last {extra}"
        warnings.warn(f"{message} {'is' if extra == 1 else 'are'} left out", stacklevel=2)
    elif len(values) != frames * width:
        raise _bad_count(path, lines, first, frames, width)
    return values[: frames * width].reshape(frames, width)


def _bad_word(path: Path, lines: list[str], first: int) -> BadInput:
    for index, line in _filled(lines, first):
        for word in line.split():
            if parse_number(word) is None:
                where = f"{path}, line {index + 1}"
                return BadInput(f"{word[:40]!r} is not a usable number", where=where, right="a finite number")
    return BadInput("the channel values cannot be read", where=path, right="finite numbers")


def _bad_count(path: Path, lines: list[str], first: int, frames: int, width: int) -> BadInput:
    counts = [(index, len(line.split())) for index, line in _filled(lines, first)]
    right = f"{frames} lines of {width} numbers, as Frames and CHANNELS say"
    for index, count in counts:
        if count != width:
            return BadInput(f"the line has {count} numbers", where=f"{path}, line {index + 1}", right=right)
    return BadInput(f"there are {len(counts)} frames", where=path, right=right)


def _put_in_place(hierarchy: Hierarchy, values: np.ndarray) -> None:
    """Replace the OFFSETs of all joints by their position channels, in place.

    Those of a root always do. Those of other joints do so in most files (Maya, MotionBuilder, Blender) but are added to
    it in some (MakeHuman), where they are nearer to 0 in the first two frames, of which one may be a T pose.
    """
    column = 0
    for joint in hierarchy.joints:
        places = [i for i, name in enumerate(joint.channels) if name.endswith("position")]
        columns = [column + i for i in places]
        offset = np.array(joint.offset)[["XYZ".index(joint.channels[i][0]) for i in places]]
        first = values[:2, columns]
        nearer = np.linalg.norm(first, axis=1) < np.linalg.norm(first - offset, axis=1)
        if joint.parent >= 0 and nearer.all():
            values[:, columns] += offset
        column += len(joint.channels)
