"""Analytic bodies in motion, after a study of what makes interpolations between frames fail."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hairpipe.geometry.rotations import exponential
from hairpipe.graphs.experiments.studies.interpolation.solids import Solid, capsule, ellipsoid

Path = Callable[[float], np.ndarray]
"""Poses [R | p] [m] at a time in frames, (G, 3, 4)."""

STILL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class Case(NamedTuple):
    """Solids that move, between frames 0 and 1.

    radius  of the ball around the first of them [m], the unit of the errors
    """

    name: str
    solids: tuple[Solid, ...]
    path: Path
    radius: float


class Way(NamedTuple):
    """How one solid moves: it turns about the origin of its frame, which goes along a parabola.

    begin   rotation vector at frame 0 [deg]
    turn    more by frame 1, about the world's axes [deg]
    travel  of the origin by frame 1 [m]
    rest    where the origin is at frame 0 [m]
    extra   acceleration [m/frame^2]
    """

    begin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    travel: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rest: tuple[float, float, float] = (0.0, 0.0, 0.0)
    extra: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def pose(self, a: float) -> np.ndarray:
        """Return [R | p] at a time in frames, (3, 4)."""
        R = exponential(np.radians(self.turn) * a) @ exponential(np.radians(self.begin))
        p = np.array(self.rest) + a * np.array(self.travel) + 0.5 * (a * a - a) * np.array(self.extra)
        return np.column_stack([R, p])


def moved(name: str, *pairs: tuple[Solid, Way]) -> Case:
    """Make a case of solids, each with its way."""
    solids, ways = zip(*pairs, strict=True)
    return Case(name, solids, lambda a: np.array([way.pose(a) for way in ways]), solids[0].radius)


EGG = ellipsoid((0.6, 0.45, 0.3))
ROD = capsule(0.3, 0.4)
LIMB = capsule(0.25, 0.5, (0.5, 0.0, 0.0))
HEAD = ellipsoid((0.6, 0.45, 0.3), (0.25, 0.0, 0.0))
SHOULDER = capsule(0.3, 0.6)

# They travel by so much, or turn by so many degrees, from one frame to the next; the hinges open by 60 degrees, from so
# many; a rod slides past another, and a chin turns by 60 degrees over a shoulder.
CASES = (
    moved("1 radius", (EGG, Way(travel=(0.6, 0.0, 0.0)))),
    moved("2 radii", (EGG, Way(travel=(1.2, 0.0, 0.0)))),
    moved("turn 30", (EGG, Way(turn=(0.0, 0.0, 30.0)))),
    moved("turn 60", (EGG, Way(turn=(0.0, 0.0, 60.0)))),
    moved("arc 60", (ellipsoid((0.3, 0.3, 0.3), (0.6, 0.0, 0.0)), Way(turn=(0.0, 0.0, 60.0)))),
    moved("go and turn", (ROD, Way(turn=(0.0, 0.0, 45.0), travel=(0.0, 0.7, 0.0)))),
    moved("accelerate", (EGG, Way(travel=(0.6, 0.0, 0.0), extra=(0.6, 0.0, 0.0)))),
    moved(
        "hinge 40",
        (LIMB, Way()),
        (LIMB, Way(begin=(0.0, 0.0, 40.0), turn=(0.0, 0.0, 60.0))),
    ),
    moved("hinge 5", (LIMB, Way()), (LIMB, Way(begin=(0.0, 0.0, 5.0), turn=(0.0, 0.0, 60.0)))),
    moved("slide past", (ROD, Way(rest=(-0.35, 0.7, 0.0), travel=(0.7, 0.0, 0.0))), (ROD, Way())),
    moved(
        "chin turns",
        (HEAD, Way(begin=(0.0, -30.0, 0.0), turn=(0.0, 60.0, 0.0))),
        (SHOULDER, Way(rest=(0.1, -0.83, 0.0))),
    ),
    moved("length + 60", (EGG, Way(turn=(0.0, 0.0, 60.0), travel=(1.2, 0.3, 0.0)))),
)
