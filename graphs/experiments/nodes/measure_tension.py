"""What strands pull with, as numbers."""

from hairpipe.data import Groom, Table
from hairpipe.data.hair import HairState
from hairpipe.graph import Frames, Time, node


@node(frames="once")
def measure_tension(groom: Groom, states: Frames[HairState], time: Time, *, moments: tuple[int, ...] = ()) -> Table:
    """The tension of every segment of every strand, and how far the strand has turned up to there.

    moments  frames to examine, as far as they are among the frames of the run; all if not given
    """
    from hairpipe.measure.tension import measure_tensions

    return measure_tensions(groom, states, time.fps, moments)
