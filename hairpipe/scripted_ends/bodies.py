"""A rigid body carried along keys: its mesh, and its level set, whose samples stay fixed in a frame that moves."""

import numpy as np

from hairpipe.data import BodyParts, LevelSet, Mesh
from hairpipe.errors import BadInput
from hairpipe.levelset.bake.parts import gathered
from hairpipe.scripted_ends.ends import follow
from hairpipe.scripted_ends.track import Track

NAME = "body"


def moved(mesh: Mesh, track: Track, time: float) -> Mesh:
    """Return a mesh moved by keys at a time [s], with the exact velocities of that motion.

    The pivot of the track is a place in space; the mesh may move by itself, too.
    """
    place, rate = (motion[0] for motion in follow(track, np.zeros((1, 3)), time))
    points = mesh.points @ place[:, :3].T + place[:, 3]
    velocities = mesh.points @ rate[:, :3].T + rate[:, 3]
    if mesh.velocities is not None:
        velocities += mesh.velocities @ place[:, :3].T
    return Mesh(points, mesh.triangles, velocities, mesh.uv)


def moved_surface(surface: LevelSet, track: Track, time: float) -> BodyParts:
    """Return the level set of a body where keys take it at a time [s], as a body of one part.

    The pivot of the track is a place in space. Raises BadInput where the body is not at rest, too: its level set would
    have to be baked at every frame.
    """
    if surface.velocity.any():
        right = "the level set of a mesh at rest, before it is moved"
        raise BadInput("the body is not at rest", where="in.surface", right=right)
    place, rate = follow(track, np.zeros((1, 3)), time)
    return gathered((NAME,), place, rate, [surface])
