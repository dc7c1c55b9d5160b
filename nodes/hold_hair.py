"""One moment of moving hair."""

from hairpipe.data import Strands
from hairpipe.graph import Frames, node


@node(frames="once")
def hold_hair(hair: Frames[Strands], *, frame: int | None = None) -> Strands:
    """Hair at one frame, for all frames.

    frame  that is held; without, the last of the run
    """
    from hairpipe.errors import BadInput

    held = hair.numbers[-1] if frame is None else frame
    if held not in hair.numbers:
        raise BadInput(f"frame {held} is not run", where="frame", right=f"{hair.numbers[0]} to {hair.numbers[-1]}")
    return hair[held]
