"""Errors of hair that follows guides."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.units import Ge
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_guides(
    hair: Frames[Strands],
    truth: Frames[Strands],
    twins: tuple[Frames[Strands], ...] | None,
    *,
    skip: Annotated[int, Ge(0)] = 1,
) -> Table:
    """Measure interpolated hair against a full simulation: one row of errors of strands, with the part that is chance.

    The error of a strand is the root mean square over its points and all frames. `twins` are other members of the
    ensemble of `truth` (`perturb_groom`): half their mean square distance is the floor, which is subtracted in the last
    columns. The same columns as in the table of `choose_guides`, for other motions and for guides simulated alone.

    skip  number of frames to exclude at the beginning
    """
    from hairpipe.measure.following import following_table

    return following_table(hair, truth, twins or (), skip)
