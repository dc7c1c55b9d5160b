"""Special parameters and outputs of a node, besides values: time, files, and a folder to write in."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, NamedTuple, NewType, TypeVar

T = TypeVar("T")


class Pair(NamedTuple, Generic[T]):
    """A value at the previous frame and at this one; at the first frame of the range both are the current one."""

    previous: T
    current: T


@dataclass(frozen=True)
class Time:
    """When a node is evaluated; only a node that asks for it depends on it.

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

A `once` node sees the cuts within the run, an `each` node all of them, a scan its own frame alone, where that is a cut.
"""


class Frames(Mapping[int, T]):
    """A value at every frame of the run, by frame number; read when asked for and not kept.

    numbers  of the frames, ascending
    load     gives the value at a frame; `Frames((1, 2), {1: a, 2: b}.__getitem__)` makes one by hand
    """

    def __init__(self, numbers: tuple[int, ...], load: Callable[[int], T]) -> None:
        self.numbers = numbers
        self._load = load
        self._known = frozenset(numbers)

    def __getitem__(self, frame: int) -> T:
        """Read the value at a frame; KeyError where the run has no such frame."""
        if frame not in self._known:
            raise KeyError(frame)
        return self._load(frame)

    def __contains__(self, frame: object) -> bool:
        """Whether the run has this frame, without reading its value."""
        return frame in self._known

    def __iter__(self) -> Iterator[int]:
        """Iterate over the frame numbers."""
        return iter(self.numbers)

    def __len__(self) -> int:
        """Count the frames."""
        return len(self.numbers)


class Reached(Frames[T]):
    """A value at every frame of the run that its node reached: a scan that diverges on the way ends there."""


@dataclass(frozen=True)
class Spent:
    """What one result took when it was computed, as its record has it: `Frames[Spent]` takes it of any node.

    It is keyed by the result's own key, not by its value: two simulations that come to the same hair keep their own
    times. As long as the node's code, settings and inputs stay the same, so does what was recorded first.

    seconds    that passed [s]
    processor  seconds of the processor, of all threads and children [s]
    """

    seconds: float
    processor: float


Workspace = NewType("Workspace", Path)
"""An empty folder of its own for one evaluation of a node; gone afterwards."""


DATA_SUFFIXES = (
    *(".abc", ".bvh", ".csv", ".exr", ".gif", ".h5", ".jpeg", ".jpg", ".mp4", ".npy", ".npz", ".obj", ".pdf", ".png"),
    *(".tif", ".tiff", ".usd", ".usda", ".usdc", ".vdb", ".webp"),
)
"""Formats of pictures and data, which no program executes."""


@dataclass(frozen=True)
class File:
    """A file that a node has written in its workspace; it is stored, and published, by its bytes.

    A node declares its formats as `-> Annotated[File, Suffixes((".png",))]`: it is published under such a suffix only.
    A node that declares none may publish under those of `DATA_SUFFIXES`.

    path        of the file
    companions  files that must lie next to it, by the relative name under which the file refers to them
    """

    path: Path
    companions: Mapping[str, Path] = field(default_factory=dict)
