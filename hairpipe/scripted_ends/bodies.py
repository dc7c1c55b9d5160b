"""A body carried along keys."""

import numpy as np

from hairpipe.data import Mesh
from hairpipe.scripted_ends.ends import follow
from hairpipe.scripted_ends.track import Track


def carried(mesh: Mesh, track: Track, time: float) -> Mesh:
    """Return a mesh where keys take it at a time [s], with the exact velocities of that motion.

    The pivot of the track is a place in space; the mesh may move by itself, too.
    """
    place, rate = (motion[0] for motion in follow(track, np.zeros((1, 3)), time))
    points = mesh.points @ place[:, :3].T + place[:, 3]
    velocities = mesh.points @ rate[:, :3].T + rate[:, 3]
    if mesh.velocities is not None:
        velocities += mesh.velocities @ place[:, :3].T
    return Mesh(points, mesh.triangles, velocities, mesh.uv)
