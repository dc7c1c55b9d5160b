"""Level set of a rigid body moved by keys."""

from hairpipe.body.scripted_motion import Track
from hairpipe.engine import Cuts, Time, node
from hairpipe.values import BodyParts, LevelSet


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
    from hairpipe.body.scripted_motion import instant_of, moved_surface

    return moved_surface(surface, motion, instant_of(time.frame, at, time.fps, cuts))
