"""How hair gets on with bodies, as numbers."""

from hairpipe.data import BodyParts, LevelSet, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_contact(
    hair: Frames[Strands],
    surfaces: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    time: Time,
) -> Table:
    """At every frame, how deep hair is inside bodies, how fast it is, and how far stretched.

    The deepest point, the depth that 99 % keep to and how many are inside are without those that began inside in the
    first frame and are not yet out, and without those that are pinched where bodies leave no room. Both have columns of
    their own.
    """
    from hairpipe.measure.contact import measure_contacts

    return measure_contacts(hair, surfaces or (), parts or (), time.fps)
