"""Mesh moved by keys."""

from hairpipe.body.scripted_motion import Track
from hairpipe.engine import Cuts, Time, node
from hairpipe.values import Mesh


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
    from hairpipe.body.scripted_motion import instant_of, moved

    return moved(mesh, motion, instant_of(time.frame, at, time.fps, cuts))
