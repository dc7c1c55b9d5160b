"""How deep hair is inside the body, as numbers."""

from hairpipe.data import LevelSet, Strands, Table
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_contact(hair: Frames[Strands], surfaces: tuple[Frames[LevelSet], ...], time: Time) -> Table:
    """At every frame, the deepest point inside the bodies, the depth that 99 % keep to, and how many are inside."""
    from hairpipe.measure.contact import measure_depths

    return measure_depths(hair, surfaces, time.fps)
