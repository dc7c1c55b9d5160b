"""Hair as loosely connected particles, after Bando, Chen, Nishita 2003: at rest, at one frame, between two frames."""

import numpy as np

from hairpipe.values.groom import Groom
from hairpipe.values.value import value


@value
class Particles:
    """Particles that represent hair at rest, and the links between them; those below the skin come first.

    hair        strands on which the particles lie, at rest
    strands     strand of `hair` of each particle, (N,) int32
    arcs        arc length from the skin, along the axis of a curl; negative below the skin [m], (N,) float64
    points      [m], (N, 3) float64
    directions  directions of the hair towards the tip, unit vectors, (N, 3) float64
    masses      [kg], (N,) float64
    links       pairs of particles, the one nearer to the root first, (E, 2) int32
    alignments  a_ij of equation (6) at rest, (E,) float64
    reach       h_1: link strength is zero at twice this distance [m]
    range       h_2: hairs interact within twice this distance [m]
    """

    hair: Groom
    strands: np.ndarray
    arcs: np.ndarray
    points: np.ndarray
    directions: np.ndarray
    masses: np.ndarray
    links: np.ndarray
    alignments: np.ndarray
    reach: float
    range: float


@value
class Cloud:
    """Particles at one frame; order and count are those at rest.

    points      [m], (N, 3) float64
    velocities  [m/s], (N, 3) float32
    directions  of the hair there, unit vectors, (N, 3) float64
    """

    points: np.ndarray
    velocities: np.ndarray
    directions: np.ndarray


@value
class ParticleState:
    """Everything the next frame of particles needs.

    points      [m], (N, 3) float64
    velocities  [m/s], (N, 3) float64
    directions  unit vectors, (N, 3) float64
    tensions    of the links [N], (E,) float64
    """

    points: np.ndarray
    velocities: np.ndarray
    directions: np.ndarray
    tensions: np.ndarray
