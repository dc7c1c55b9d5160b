"""How far particles may be from their roots: hair has a length, and links that are torn apart know nothing of it.

A particle of hair is no farther from its root than the hair is long, and than its links stretch it: by `sag` at the
root where it hangs, by half of that on average, and by ten times as much at ten times its weight. What comes farther is
taken back along the straight line to the root, and loses its speed away from there. It is warned of. What comes
`TORN` times as far in a frame was no motion of hair, and the shot has diverged.
"""

from warnings import warn

import numpy as np

from hairpipe.data import Particles
from hairpipe.data.lengths import strand_lengths
from hairpipe.groom.binding import name_strands
from hairpipe.particles.model import Moving
from hairpipe.sim.boundary import Lead, motion_of_roots

LOAD = 10.0
"""Times the weight of hair under which links may stretch it."""
TORN = 100.0
"""Distance from the root, over the largest that is possible, at which a shot has diverged."""


def reaches_of(particles: Particles, sag: float) -> np.ndarray:
    """Return how far from its root each particle may be [m], (N,); pure.

    The way along the hair, of a curl, whose places are along its axis, the share of its whole length, and the reach of
    links more: so far a particle may stand for hair that lies beside it.
    """
    lengths = strand_lengths(particles.hair.points, particles.hair.offsets)
    farthest = np.zeros(len(lengths))
    np.maximum.at(farthest, particles.strands, particles.arcs)
    share = np.maximum(particles.arcs, 0.0) / np.maximum(farthest, np.finfo(float).tiny)[particles.strands]
    return (share * lengths[particles.strands] + particles.reach) * (1.0 + LOAD * sag / 2.0)


def keep_within_reach(
    particles: Particles, reaches: np.ndarray, lead: Lead, deep: int, frame: int, moving: Moving
) -> None:
    """Take particles back to within reach of their roots, in place, and warn of it.

    reaches  as `reaches_of` finds them [m], (N,)
    lead     what leads the roots at the end of the frame
    deep     number of particles below the skin, which come first

    Raises ArithmeticError where one is `TORN` times as far away.
    """
    hair, strands = particles.hair, particles.strands[deep:]
    motions, rates = motion_of_roots(lead, hair)
    ends = hair.points[hair.offsets[:-1]]
    roots, drifts = (np.einsum("sij,sj->si", m[:, :, :3], ends) + m[:, :, 3] for m in (motions, rates))
    ways = moving.points[deep:] - roots[strands]
    distances, most = np.linalg.norm(ways, axis=1), reaches[deep:]
    beyond = distances > most
    if not beyond.any():
        return
    worst = int(np.argmax(distances / most))
    who = name_strands(hair.ids[np.unique(strands[beyond])])
    far = f"the farthest {distances[worst]:.3g} m, over {most[worst]:.3g} m, on strand {hair.ids[strands[worst]]}"
    said = f"{np.count_nonzero(beyond)} of {len(beyond)} particles are too far from their roots at frame {frame}, {far}"
    if distances[worst] > TORN * most[worst]:
        raise ArithmeticError(f"diverged: {said}: {who}")
    warn(f"{said}, and were taken back: {who} (more steps, or less wind)", stacklevel=3)
    units = ways[beyond] / distances[beyond, None]
    moving.points[deep:][beyond] = roots[strands[beyond]] + most[beyond, None] * units
    drift = drifts[strands[beyond]]
    away = np.einsum("ni,ni->n", moving.velocities[deep:][beyond] - drift, units)
    moving.velocities[deep:][beyond] -= np.maximum(away, 0.0)[:, None] * units
