"""Ways to choose guides, compared."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.units import Interval
from hairpipe.values import Groom, Mesh, Strands, Table


@node(frames="once")
def compare_guides(
    groom: Groom,
    hair: Frames[Strands],
    body: Frames[Mesh],
    twin: Frames[Strands],
    other: Frames[Strands],
    other_body: Frames[Mesh],
    other_twin: Frames[Strands],
    *,
    every: tuple[Annotated[int, Interval(ge=1, le=1_000_000)], ...],
    samples: Annotated[int, Interval(ge=1, le=1000)] = 16,
) -> Table:
    """Measure hair that follows guides of a full simulation, for choices of guides and ways to follow them.

    Guides are one strand in n, the farthest roots, or those of `choose_guides`. Strands follow the nearest ones, or the
    fitted guidance. Errors are those at frames that nothing was fitted to, and those in another motion.

    every    numbers of strands per guide
    samples  number of frames to which guidance is fitted
    """
    from hairpipe.graphs.experiments.measure.guides import Motion, compared

    motions = Motion(hair, body, twin), Motion(other, other_body, other_twin)
    return compared(groom, motions, every, samples)
