"""Mesh moved by keys."""

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
    """Move and rotate a mesh by keys, in addition to its own motion, with exact velocities.

    at      frame of the shot at time zero of the keys
    motion  motion by keys: displacements from the place of the mesh, rotations about a pivot in space; `move_levelset`
            applies the same keys to a level set
    """
    from hairpipe.scripted_ends.bodies import moved
    from hairpipe.scripted_ends.track import instant_of

    return moved(mesh, motion, instant_of(time.frame, at, time.fps, cuts))
