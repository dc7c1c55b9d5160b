"""Special parameters and outputs of a node: time, cuts, files, and a workspace."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, NamedTuple, NewType, TypeVar

T = TypeVar("T")


class Pair(NamedTuple, Generic[T]):
    """A value at the previous and at the current frame; at the first frame of the range both are the current value."""

    previous: T
    current: T


@dataclass(frozen=True)
class Time:
    """Time of an evaluation; only nodes with this parameter depend on it.

    frame  number of the frame; in a `once` node the first frame of the run
    fps    frames per second [1/s]
    """

    frame: int
    fps: float

    @property
    def dt(self) -> float:
        """Length of a frame [s]."""
        return 1.0 / self.fps


Cuts = NewType("Cuts", tuple[int, ...])
"""Frames at which the shot is cut, ascending: positions there are discontinuous with those of the previous frame.

A `once` node receives the cuts within the run, an `each` node all cuts, a scan its own frame if it is a cut.
"""


First = NewType("First", int)
"""First frame of the shot, without preroll: a longer range at its end does not change it."""


class Frames(Mapping[int, T]):
    """A value at every frame of the run, by frame number; loaded on access and not cached.

    numbers  of the frames, ascending
    load     returns the value at a frame, as in `Frames((1, 2), {1: a, 2: b}.__getitem__)`
    """

    def __init__(self, numbers: tuple[int, ...], load: Callable[[int], T]) -> None:
        self.numbers = numbers
        self._load = load
        self._known = frozenset(numbers)

    def __getitem__(self, frame: int) -> T:
        """Read the value at a frame; KeyError for a frame outside of the run."""
        if frame not in self._known:
            raise KeyError(frame)
        return self._load(frame)

    def __contains__(self, frame: object) -> bool:
        return frame in self._known

    def __iter__(self) -> Iterator[int]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)


class Reached(Frames[T]):
    """A value at every frame of the run before the frame at which a scan diverged."""


@dataclass(frozen=True)
class Spent:
    """Computation time of one result, from its record; `Frames[Spent]` accepts any node.

    It is part of a key by the key of the result, not by its value: equal results of two simulations have their own
    times. The first recorded time is valid as long as code, settings and inputs of the node are unchanged.

    seconds    wall-clock time [s]
    processor  processor time of all threads and child processes [s]
    """

    seconds: float
    processor: float


Workspace = NewType("Workspace", Path)
"""A new empty folder for one evaluation of a node, which is removed afterwards."""


DATA_SUFFIXES = (
    *(".abc", ".bvh", ".csv", ".exr", ".gif", ".h5", ".jpeg", ".jpg", ".mp4", ".npy", ".npz", ".obj", ".pdf", ".png"),
    *(".tif", ".tiff", ".usd", ".usda", ".usdc", ".vdb", ".webp"),
)
"""Formats of pictures and data, which no program executes."""


@dataclass(frozen=True)
class File:
    """A file in the workspace of a node; its bytes are stored and published.

    A node declares its formats as `-> Annotated[File, Suffixes((".png",))]`, and is published with such a suffix only;
    without a declaration, with those of `DATA_SUFFIXES`.

    path        of the file
    companions  files that must be next to it, by the relative path in the file
    """

    path: Path
    companions: Mapping[str, Path] = field(default_factory=dict)
