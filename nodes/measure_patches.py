"""How far hair is from the same hair simulated otherwise, as numbers."""

from typing import Annotated

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, node
from hairpipe.units import Interval


@node(frames="once")
def measure_patches(
    hair: Frames[Strands], reference: Frames[Strands], *, patches: Annotated[int, Interval(ge=1, le=10_000)] = 4
) -> Table:
    """At every frame, for every patch of strands: distance of tips and of whole strands from a reference, in m and %.

    The two may be cut into different segments; % are of the length of a strand.

    patches  of a sample, in order
    """
    from hairpipe.measure.patches import measure_patches as measure

    return measure(hair, reference, patches)
