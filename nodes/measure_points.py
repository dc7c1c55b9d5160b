"""Values at the points of hair, for colours."""

from hairpipe.engine import node
from hairpipe.values import BodyParts, Groom, LevelSet, PointValues, Strands
from hairpipe.values.hair import HairState


@node(frames="each")
def measure_points(
    hair: Strands,
    groom: Groom | None,
    state: HairState | None,
    surfaces: tuple[LevelSet, ...] | None,
    parts: tuple[BodyParts, ...] | None,
) -> PointValues:
    """Measure depth in bodies, stretch, tension and lock at every point, for colours in `hairpipe view`."""
    from hairpipe.measure.contact import still
    from hairpipe.measure.motion import measure_points as measure

    return measure(hair, groom, state, still(surfaces or (), parts or ()))
