"""A body carried along keys."""

from hairpipe.data import Mesh
from hairpipe.graph import Cuts, Time, node
from hairpipe.scripted_ends.track import Track


@node(frames="each")
def move_mesh(
    mesh: Mesh,
    time: Time,
    cuts: Cuts,
    *,
    at: int = 1001,
    motion: Track = Track(),  # noqa: B008 (frozen)
) -> Mesh:
    """The mesh at a frame, where keys move and turn it, in addition to its own motion; with exact velocities.

    at      frame of the shot at which time is zero
    motion  keys; moves are from where the mesh is, and the pivot of the turns is a place in space; `move_levelset`
            takes the same and carries the level set of the still mesh along, which is then baked once
    """
    from hairpipe.scripted_ends.bodies import carried
    from hairpipe.scripted_ends.track import instant_of

    return carried(mesh, motion, instant_of(time.frame, at, time.fps, cuts))
