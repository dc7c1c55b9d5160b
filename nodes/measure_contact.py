"""Contact of hair with bodies, in numbers."""

from hairpipe.engine import Frames, Time, node
from hairpipe.values import BodyParts, LevelSet, Strands, Table


@node(frames="once")
def measure_contact(
    hair: Frames[Strands],
    surfaces: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    time: Time,
) -> Table:
    """Measure depth in bodies, speed and stretch of hair at every frame.

    The maximum depth, its 99th percentile and the number of points inside exclude points that were inside in the first
    frame and have not left, and points that bodies pinch. Both kinds have their own columns.
    """
    from hairpipe.measure.contact import measure_contacts

    return measure_contacts(hair, surfaces or (), parts or (), time.fps)
