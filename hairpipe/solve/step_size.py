"""Step sizes between two frames: each limit is an object, the shortest step is used."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from math import ceil, inf
from typing import ClassVar

import numpy as np
from numba import njit, prange

from hairpipe.laws.settings import StepControl
from hairpipe.solve.boundary import ClampPath
from hairpipe.solve.stage import State
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StrandModel
from hairpipe.strands.network import stiffest_springs

_SHORTEST = 0.25
"""Step that crossing hair may ask for, over the longest."""
_SHORTER, _LONGER = 0.5, 1.25
"""Range of the ratio of consecutive steps."""
_CHUNK = 1024
"""Vectors of lanes that one thread compares at a time."""
_COUNTED = 2**31
"""Maximum number of counted steps."""


Lane = tuple[int, int] | None
"""Block and lane of a strand; None: no single strand."""


class TooManySteps(ArithmeticError):
    """A frame would take more steps than it may: what is left of it so many [1], by a setting, for a strand."""

    def __init__(self, setting: str, steps: float, lane: Lane) -> None:
        super().__init__(f"{setting} requires {steps:.2g} further steps in a frame")
        self.setting, self.steps, self.lane = setting, steps, lane


class Limit(ABC):
    """A bound on the step from the motion of hair and roots.

    setting  name of its setting in `StepControl`
    """

    setting: ClassVar[str]

    @abstractmethod
    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Find the longest step from a time since the last frame [s]."""

    def worst(self, state: State, path: ClampPath, time: float) -> Lane:
        """Find the strand that asks for the shortest step; None: all ask for the same."""
        return None


@dataclass(frozen=True)
class Fixed(Limit):
    """Steps of one length [s], or an equal share of a frame that is shorter."""

    setting: ClassVar[str] = "longest"
    step: float

    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Return that length."""
        return self.step


@dataclass(frozen=True, eq=False)
class Courant(Limit):
    """The stability limit of an explicit step, times a factor: dt = cfl / sqrt(max_p sum_s 4 k_s / (m_p l0_s)).

    The sum runs over the springs at a particle, and over its connections by stiction. [code] of the authors: 4 for
    heads, 10 for single strands; stiction, which is explicit there, is not included.
    """

    setting: ClassVar[str] = "courant"
    number: float
    model: StrandModel
    around: Surroundings
    stiffest: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffest", stiffest_springs(self.model)[0])

    def worst(self, state: State, path: ClampPath, time: float) -> Lane:
        """Find the strand with the stiffest springs for their masses."""
        return stiffest_springs(self.model)[1:]

    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Return that length: without stiction it depends on nothing that moves."""
        return self.number / np.sqrt(self.stiffest + self.around.stiffness())


@dataclass(frozen=True, eq=False)
class StrainRate(Limit):
    """An edge changes its length by at most a fraction of it: dt = fraction / max |(v_q - v_p) . d| / l0, Sec. 4."""

    setting: ClassVar[str] = "strain_rate"
    model: StrandModel
    fraction: float

    def worst(self, state: State, path: ClampPath, time: float) -> Lane:
        """Find the strand with the edge that is strained fastest."""
        return self._fastest(state)[1:]

    def _fastest(self, state: State) -> tuple[float, int, int]:
        return _strain_rate(self.model.first, self.model.inverse_lengths, self.model.shape, state.x, state.v)

    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Find the fastest strain."""
        rate = self._fastest(state)[0]
        return self.fraction / rate if rate > 0.0 else np.inf


@dataclass(frozen=True, eq=False)
class Travel(Limit):
    """Maximum displacement of a particle, and of a body that it may collide with [m].

    Larger displacements miss no contact; but a body that moves farther than its own thickness in one step stretches
    hair (`graphs/experiments/stability_contact.toml`: a bar of 3 cm).
    """

    setting: ClassVar[str] = "travel"
    distance: float
    around: Surroundings

    def worst(self, state: State, path: ClampPath, time: float) -> Lane:
        """Find the fastest strand, where no body is faster."""
        speed, row, lane = _largest(state.v)
        first = self.around.model.first
        return (int(np.searchsorted(first, row, "right")) - 1, lane) if speed >= self.around.fastest() else None

    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Divide by the highest speed."""
        speed = max(_largest(state.v)[0], self.around.fastest())
        return self.distance / speed if speed > 0.0 else np.inf


@dataclass(frozen=True)
class Root(Limit):
    """A held particle moves at most this far [m]: 1 cm in the authors' code."""

    setting: ClassVar[str] = "root"
    distance: float

    def worst(self, state: State, path: ClampPath, time: float) -> Lane:
        """Find the strand whose ends go farthest in what is left of the frame."""
        way = path.way(path.ends(time), path.frame_dt)
        _, row, lane = _farthest(way)
        return row // way.shape[1], lane

    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Shorten the rest of the frame until the ends keep to the distance: twice as many steps, then as few as do."""
        left = path.frame_dt - time
        here = path.ends(time)

        def is_far(count: int) -> bool:
            return _farthest(path.way(here, time + left / count))[0] > self.distance

        few, many = 0, 1
        while is_far(many) and many < _COUNTED:
            few = many
            many = 2 * many
        while many - few > 1:
            middle = (few + many) // 2
            few, many = (middle, many) if is_far(middle) else (few, middle)
        return left / many


@dataclass(eq=False)
class CrossingLimit(Limit):
    """A bound on the step that keeps the number of crossings to resolve small.

    Crossings that the solve of a step misses, since it is linear and its contact is soft, are corrected afterwards by
    moving the points of two segments. That stretches their strands, by the square of the displacement in a step, and
    the next solve makes them cross again. Such hair packs more and more densely: at a constant 1/96 s, 10,000 hairs in
    a vigorous shake jam, and cost twice as much (docs/results/paper.md).

    part  maximum number of resolved pairs per segment in a step
    most  longest step without such pairs [s]
    step  longest step allowed at present [s]
    """

    setting: ClassVar[str] = "crossings"
    part: float
    most: float
    step: float

    def longest(self, state: State, path: ClampPath, time: float) -> float:
        """Return the step that is allowed now."""
        return self.step

    def follow(self, dt: float, crossed: float) -> None:
        """Update the bound by the number of pairs per segment that a step of dt [s] resolved.

        In packed hair it grows about as dt^1.5. Steps lengthen slowly to avoid oscillation.
        """
        change = min(max((self.part / crossed) ** (2.0 / 3.0), _SHORTER), _LONGER) if crossed > 0.0 else _LONGER
        step = dt * change if change < 1.0 else max(dt * change, self.step)
        self.step = min(max(step, _SHORTEST * self.most), self.most)


def crossing_limit(control: StepControl, step: float) -> CrossingLimit:
    """Go on at the pace at which hair went before [s]."""
    return CrossingLimit(control.crossings, control.longest, min(step, control.longest))


def limits_of(control: StepControl, model: StrandModel, around: Surroundings) -> list[Limit]:
    """Collect the limits that a scene asks for."""
    limits: list[Limit] = [Fixed(control.longest), Travel(control.travel, around), Root(control.root)]
    if control.strain_rate is not None:
        limits.append(StrainRate(model, control.strain_rate))
    if control.courant is not None:
        limits.append(Courant(control.courant, model, around))
    return limits


def next_step(limits: list[Limit], state: State, path: ClampPath, time: float, most: int = 10**9) -> float:
    """Choose the step at a time since the last frame [s]: an equal share of the rest of the frame.

    Raises TooManySteps if more than `most` would be needed.
    """
    left = path.frame_dt - time
    longest, limit = min(((limit.longest(state, path, time), limit) for limit in limits), key=lambda found: found[0])
    steps = left / longest if longest > left * 1e-300 else inf
    if steps - 1e-6 > most:
        raise TooManySteps(limit.setting, steps, limit.worst(state, path, time))
    return left / max(ceil(steps - 1e-6), 1)


def _farthest(way: np.ndarray) -> tuple[float, int, int]:
    """Length of the longest of ways (blocks, n, 3, W) [m], which of the blocks times n it is, and its lane."""
    return _largest(way.reshape(-1, *way.shape[2:]))


@njit(cache=True)
def _strain_rate(first, inverse_lengths, shape, x, v):
    """Find the largest rate of strain of an edge on the axis [1/s], its block and lane."""
    fastest = 0.0
    where = 0
    which = 0
    stride = shape.stride
    for block in range(len(first) - 1):
        for p in range(first[block] + shape.before, first[block + 1] - stride - shape.after, stride):
            for lane in range(x.shape[2]):
                length, closing = 0.0, 0.0
                for c in range(3):
                    d = x[p + stride, c, lane] - x[p, c, lane]
                    length += d * d
                    closing += d * (v[p + stride, c, lane] - v[p, c, lane])
                if length > 0.0:
                    rate = abs(closing) / np.sqrt(length) * inverse_lengths[p, stride - 1, lane]
                    if fastest < rate < np.inf:  # A lost strand, inf or NaN, must not stop all others.
                        fastest, where, which = rate, block, lane
    return fastest, where, which


@njit(cache=True, parallel=True)
def _largest(vectors: np.ndarray) -> tuple[float, int, int]:
    """Length of the longest finite vector of (n, 3, W), its row and lane: the first of equal ones."""
    chunks = max(1, -(-len(vectors) // _CHUNK))
    longest = np.zeros(chunks)
    places = np.zeros(chunks, np.int64)
    width = vectors.shape[2]
    for chunk in prange(chunks):
        for n in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(vectors))):
            for lane in range(width):
                size = vectors[n, 0, lane] ** 2 + vectors[n, 1, lane] ** 2 + vectors[n, 2, lane] ** 2
                if longest[chunk] < size < np.inf:  # The same: what is not finite bounds no step.
                    longest[chunk], places[chunk] = size, n * width + lane
    best = 0
    for chunk in range(1, chunks):
        best = chunk if longest[chunk] > longest[best] else best
    return np.sqrt(longest[best]), places[best] // width, places[best] % width
