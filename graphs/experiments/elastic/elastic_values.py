"""Bodies of springs: a solid of tetrahedra and a shell of triangles at rest, and the state of either while it moves."""

import numpy as np

from hairpipe.values.value import value


@value
class Solid:
    """Tetrahedra at rest.

    points      [m], (n, 3) float64
    tetrahedra  indices of particles a, b, c, d with (b-a) . (c-a) x (d-a) > 0, (t, 4) int32
    """

    points: np.ndarray
    tetrahedra: np.ndarray


@value
class Shell:
    """Triangles at rest, bent or flat.

    points     [m], (n, 3) float64
    triangles  vertex indices, all turned the same way, (m, 3) int32
    pinned     which vertices never move, (n,) bool
    """

    points: np.ndarray
    triangles: np.ndarray
    pinned: np.ndarray


@value
class ElasticState:
    """Everything the next frame needs.

    time           since the start [s]
    positions      of the particles [m], (n, 3) float64
    velocities     [m/s], (n, 3) float64
    accelerations  of the last solve [m/s^2], (n, 3) float64
    tensions       multipliers of the linear springs [N], (e,) float64
    pressed        force with which the ground carries a particle, 0 where they do not touch [N], (n,) float64
    energy         kinetic, of the springs, and of the height above the ground [J], (3,) float64
    """

    time: float
    positions: np.ndarray
    velocities: np.ndarray
    accelerations: np.ndarray
    tensions: np.ndarray
    pressed: np.ndarray
    energy: np.ndarray
