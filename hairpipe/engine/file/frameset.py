"""Frame sets as text: `1-100x2,150`."""

import re
from collections.abc import Iterable

from hairpipe.errors import BadInput

MOST_FRAMES = 1_000_000
PART = re.compile(r"(-?\d{1,9})(?:-(-?\d{1,9})(?:x(\d{1,9}))?)?")


def parse_frames(text: str) -> tuple[int, ...]:
    """Read `first-last`, `first-lastxstep` and single frames, separated by commas; ascending, without duplicates."""
    numbers: set[int] = set()
    for part in text.split(","):
        match = PART.fullmatch(part.strip())
        if not match:
            raise BadInput(f"'{text}' is not a valid frame set", right="frames and ranges such as 1-100x2,150")
        first = int(match[1])
        last = int(match[2] or match[1])
        step = int(match[3] or 1)
        if last < first or step < 1:
            raise BadInput(f"'{part}' is an empty range", right="first-last with first <= last, step >= 1")
        if (last - first) // step + len(numbers) >= MOST_FRAMES:
            raise BadInput(f"'{part}' is too long", right=f"at most {MOST_FRAMES} frames")
        numbers.update(range(first, last + 1, step))
    return tuple(sorted(numbers))


def fold_frames(frames: Iterable[int]) -> str:
    """Write frames as ranges: the inverse of `parse_frames`."""
    numbers = sorted(set(frames))
    parts = []
    start = 0
    while start < len(numbers):
        end = _run_end(numbers, start)
        step = numbers[end] - numbers[end - 1] if end > start else 1
        suffix = f"x{step}" if step > 1 else ""
        parts.append(f"{numbers[start]}-{numbers[end]}{suffix}" if end > start else str(numbers[start]))
        start = end + 1
    return ",".join(parts)


def _run_end(numbers: list[int], start: int) -> int:
    """Return the index of the last number of the evenly spaced run from `start`; a run of two has step 1."""
    end = start + 1
    if end == len(numbers):
        return start
    step = numbers[end] - numbers[start]
    while end + 1 < len(numbers) and numbers[end + 1] - numbers[end] == step:
        end += 1
    return end if step == 1 or end - start > 1 else start
