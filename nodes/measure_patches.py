"""Distances of patches of hair from a reference."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.units import Interval
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_patches(
    hair: Frames[Strands], reference: Frames[Strands], *, patches: Annotated[int, Interval(ge=1, le=10_000)] = 4
) -> Table:
    """Measure distances of tips and strands from a reference for every patch at every frame, in m and %.

    The two simulations may differ in segments; % are relative to the length of a strand.

    patches  number of patches of the sample, in order
    """
    from hairpipe.measure.deviation import measure_patches as measure

    return measure(hair, reference, patches)
