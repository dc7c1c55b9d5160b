"""Level set of a rigid body moved by keys."""

from hairpipe.data import BodyParts, LevelSet
from hairpipe.graph import Cuts, Time, node
from hairpipe.scripted_ends.track import Track


@node(frames="each")
def move_levelset(
    surface: LevelSet,
    time: Time,
    cuts: Cuts,
    *,
    at: int = 1001,
    motion: Track = Track(),  # noqa: B008 (frozen)
) -> BodyParts:
    """Move the level set of a rigid body by keys, for `parts`: baked once, exact between frames.

    at      frame of the shot at time zero of the keys
    motion  motion by keys, as in `move_mesh`
    """
    from hairpipe.scripted_ends.bodies import moved_surface
    from hairpipe.scripted_ends.track import instant_of

    return moved_surface(surface, motion, instant_of(time.frame, at, time.fps, cuts))
