"""One frame of hair as a still."""

from hairpipe.engine import Frames, node
from hairpipe.values import Strands


@node(frames="once")
def hold_hair(hair: Frames[Strands], *, frame: int | None = None) -> Strands:
    """Freeze hair at one frame.

    frame  number of the frozen frame; by default the last of the run
    """
    from hairpipe.errors import BadInput

    held = hair.numbers[-1] if frame is None else frame
    if held not in hair.numbers:
        raise BadInput(f"frame {held} is not run", where="frame", right=f"{hair.numbers[0]} to {hair.numbers[-1]}")
    return hair[held]
