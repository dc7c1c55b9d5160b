"""The surroundings of hair over a shot, frame by frame."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from hairpipe.errors import BadInput
from hairpipe.shot.shot import Frame
from hairpipe.solve.boundary import driver_of
from hairpipe.values import BodyParts, Ends, LevelSet, Mesh


class Around(NamedTuple):
    """The surroundings of hair, frame by frame; None or empty where there are none.

    cuts  frames at which the shot is cut
    """

    body: Mapping[int, Mesh] | None
    ends: Mapping[int, Ends] | None
    surfaces: Sequence[Mapping[int, LevelSet]]
    parts: Sequence[Mapping[int, BodyParts]]
    cuts: Sequence[int] = ()

    def frames(self, first: int, count: int) -> list[int]:
        """List frames, at most so many of those there are; they are counted on from the first where nothing moves.

        Raises BadInput where one is left out among them.
        """
        known = [some for some in (self.body, self.ends, *self.surfaces, *self.parts) if some is not None]
        if not known:
            return list(range(first, first + count))
        frames = list(known[0])[:count]
        for before, after in pairwise(frames):
            if after != before + 1:
                what = f"no frames between {before} and {after}, which a simulation needs"
                raise BadInput(what, where="frames", right=f"{count} of them in a row")
        return frames


def frame_between(around: Around, pair: tuple[int, int], dt: float) -> Frame:
    """Collect what hair is given at the second of two frames, dt [s] apart."""
    drivers = driver_of(_at(around.body, pair), _at(around.ends, pair)) or (None, None)
    bodies = [_pair(some, pair) for some in around.surfaces], [_pair(some, pair) for some in around.parts]
    return Frame(drivers, *bodies, (pair[1] - 1) * dt, dt, pair[1] in around.cuts)


def _pair(values: Mapping[int, object], pair: tuple[int, int]) -> tuple:
    """Read a value at two frames."""
    return values[pair[0]], values[pair[1]]


def _at(values: Mapping[int, object] | None, pair: tuple[int, int]) -> tuple | None:
    """Read a value at two frames, where there is one."""
    return None if values is None else _pair(values, pair)
