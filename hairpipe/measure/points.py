"""Values of every point of hair: depth in bodies, stretch, tension, lock."""

from collections.abc import Sequence

import numpy as np

from hairpipe.data import Groom, PointValues, Strands
from hairpipe.data.hair import HairState
from hairpipe.data.lengths import segment_lengths
from hairpipe.errors import BadInput
from hairpipe.groom.sampling import GOLDEN
from hairpipe.groom.strand_arrays import points_of_strands
from hairpipe.levelset.collider import Collider
from hairpipe.measure.contact import depths
from hairpipe.measure.tension import layout_of, tensions


def measure_points(
    hair: Strands, groom: Groom | None, state: HairState | None, bodies: Sequence[Collider]
) -> PointValues:
    """Return `depth [mm]` where there are bodies, `stretch [%]` with a groom, and `tension [uN]` with a state as well.

    For hair in locks also `lock`, a colour of each, and `follows`, 0 for simulated hair and 1 for followers, whose
    tension is that of the guide, which has as many segments.

    A point has the stretch and the tension of the segment that ends there, a root those of the first segment. Raises
    BadInput if groom or state do not match the strands.
    """
    inner = np.ones(len(hair.points), bool)
    inner[hair.offsets[:-1]] = False
    found: dict[str, np.ndarray] = {}
    if bodies:
        found["depth [mm]"] = spread(1e3 * depths(hair, bodies), inner, 0.0)
    if groom is not None:
        if not np.array_equal(groom.offsets, hair.offsets):
            raise BadInput("hair and groom are not the same strands", right="in.groom: the groom that is simulated")
        rest = segment_lengths(groom.points, groom.offsets)
        found["stretch [%]"] = spread(100.0 * (segment_lengths(hair.points, hair.offsets) / rest - 1.0), inner)
        if state is not None:
            pulls = sorted(tensions(layout_of(groom, state), state), key=lambda strand: strand[0])
            found["tension [uN]"] = spread(1e6 * np.concatenate([pull for _, _, pull in pulls]), inner)
            if state.locks is not None:
                counts = np.diff(hair.offsets)
                leaders = state.leaders(len(counts))
                found["tension [uN]"] = found["tension [uN]"][points_of_strands(leaders, hair.offsets)]
                found["lock"] = np.repeat(GOLDEN * leaders % 1.0, counts)
                found["follows"] = np.repeat(~state.simulated(len(counts)), counts).astype(float)
    if not found:
        raise BadInput("no input to measure with", right="in.surfaces, in.parts, or in.groom, with in.state or without")
    return PointValues(tuple(found), np.stack(list(found.values())).astype(np.float32), hair.offsets)


def spread(values: np.ndarray, inner: np.ndarray, root: float | None = None) -> np.ndarray:
    """Return values of all points except roots as values of all points, (p,); pure.

    inner  points that are not roots, (p,) bool
    root   value of the roots; by default that of the next point
    """
    spread_out = np.zeros(len(inner))
    spread_out[inner] = values
    roots = np.flatnonzero(~inner)
    spread_out[roots] = spread_out[roots + 1] if root is None else root
    return spread_out
