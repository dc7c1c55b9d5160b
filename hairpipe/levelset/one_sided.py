"""One-sided interpolation: phi(x, a) = phi0(x - dt a v0(x)), the frame before carried along by its own velocity."""

from hairpipe.kernels.compile import inlined
from hairpipe.levelset.departure_points import Places
from hairpipe.levelset.field import Field
from hairpipe.levelset.sample import velocity


@inlined
def one_sided_places(field0: Field, field1: Field, a: float, dt: float, x: float, y: float, z: float) -> Places:
    """Return where to read the frame before; the frame after has no say (Kim and Ko, after Selle et al. 2008).

    Discontinuous at the frame after, where the next pair of frames takes over.
    """
    vx, vy, vz = velocity(field0, x, y, z)
    s = dt * a
    return Places(0.0, x - s * vx, y - s * vy, z - s * vz, x, y, z)
