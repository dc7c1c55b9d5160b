"""Values at the points of hair, for colours."""

from hairpipe.data import BodyParts, Groom, LevelSet, PointValues, Strands
from hairpipe.data.hair import HairState
from hairpipe.graph import node


@node(frames="each")
def measure_points(
    hair: Strands,
    groom: Groom | None,
    state: HairState | None,
    surfaces: tuple[LevelSet, ...] | None,
    parts: tuple[BodyParts, ...] | None,
) -> PointValues:
    """Measure depth in bodies, stretch, tension and lock at every point, for colours in `hairpipe view`."""
    from hairpipe.measure.contact import still, still_parts
    from hairpipe.measure.points import measure_points as measure

    bodies = [*map(still, surfaces or ()), *map(still_parts, parts or ())]
    return measure(hair, groom, state, bodies)
