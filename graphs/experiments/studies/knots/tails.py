"""What is seen of a strand whose straight tails are held: their tension, and that of its middle, writhe, and size."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.measure.tensions import first_strand, frames_between
from hairpipe.graphs.experiments.measure.writhe import writhe
from hairpipe.measure.motion import layout_of
from hairpipe.values import Groom
from hairpipe.values.hair import HairState

_TAILS = 0.05
"""Part of the segments, from either end, whose tension is that of the tails."""
_MIDDLE = 0.16
"""Part of the strand, about its middle, that is far from where it touches itself."""
_FAR = 1e2
"""Length of the straight continuation of both tails, over the length of the strand: beyond it nothing writhes."""


class Seen(NamedTuple):
    """Strand 0 at a frame.

    length, span  of the strand, and the distance of its ends [m]
    tension       mean of the tails [N]
    middle        mean tension of the middle [N]
    bend          mean square of the curvature of the middle [1/m^2]
    writhe        with straight tails that go on for ever [1]
    speed         of the fastest point [m/s]
    """

    length: float
    span: float
    tension: float
    middle: float
    bend: float
    writhe: float
    speed: float


def seen_between(groom: Groom, states: Mapping[int, HairState], fps: float, window: tuple[float, float]) -> list[Seen]:
    """Look at strand 0 at every frame of a window of time since the first frame [s]; BadInput where there is none."""
    return [look(groom, states[frame]) for frame, _ in frames_between(list(states), fps, window)]


def look(groom: Groom, state: HairState) -> Seen:
    """Look at strand 0; the segments at both ends, which are held, are left out of the tails."""
    points, pulls = first_strand(groom, state)
    edges = np.diff(points, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    length = float(lengths.sum())
    many = max(1, round(_TAILS * len(edges)))
    tension = float(np.mean([*pulls[1 : 1 + many], *pulls[-1 - many : -1]]))
    inside = slice(round((0.5 - 0.5 * _MIDDLE) * len(edges)), round((0.5 + 0.5 * _MIDDLE) * len(edges)))
    before = points[0] - _FAR * length * edges[0] / lengths[0]
    after = points[-1] + _FAR * length * edges[-1] / lengths[-1]
    velocities = layout_of(groom, state).axis(state.velocities)[groom.offsets[0] : groom.offsets[1]]
    return Seen(
        length,
        float(np.linalg.norm(points[-1] - points[0])),
        tension,
        float(np.mean(pulls[inside])),
        float(np.mean(curvatures(edges)[inside] ** 2)),
        writhe(np.concatenate([[before], points, [after]])),
        float(np.linalg.norm(velocities, axis=1).max()),
    )


def curvatures(edges: np.ndarray) -> np.ndarray:
    """Return the curvature between edges, (n, 3) [m], and those after them [1/m], (n-1,): 2 tan(phi / 2) / length."""
    lengths = np.linalg.norm(edges, axis=1)
    tangents = edges / lengths[:, None]
    cosines = np.clip(np.sum(tangents[:-1] * tangents[1:], axis=1), -1.0, 1.0)
    return 2.0 * np.tan(0.5 * np.arccos(cosines)) / (0.5 * (lengths[:-1] + lengths[1:]))


def mean_over(seen: Sequence[Seen], value: Callable[[Seen], float]) -> float:
    """Return the mean of a value over frames."""
    return float(np.mean([value(one) for one in seen]))
