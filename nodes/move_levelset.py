"""The space around a rigid body that is carried along keys."""

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
    """The level set of a still body where keys take it, for `parts`: baked once, exact between frames, for any motion.

    at      frame of the shot at which time is zero
    motion  keys, as those of `move_mesh`
    """
    from hairpipe.scripted_ends.bodies import carried_surface
    from hairpipe.scripted_ends.track import instant_of

    return carried_surface(surface, motion, instant_of(time.frame, at, time.fps, cuts))
