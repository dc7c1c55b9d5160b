"""Strands deformed by particles."""

from typing import TYPE_CHECKING, Annotated

from hairpipe.engine import Time, node
from hairpipe.units import Interval, Metres
from hairpipe.values import BodyParts, Cloud, Groom, LevelSet, Mesh, Particles, Strands

if TYPE_CHECKING:
    from hairpipe.particles.skinning import Influences


def weigh(particles: Particles, groom: Groom) -> "Influences":
    """Compute the weights of particles for all points of strands, for the whole shot."""
    from hairpipe.particles.skinning import find_influences

    return find_influences(particles, groom)


@node(frames="each", prepare=weigh)
def carry_strands(
    cloud: Cloud,
    particles: Particles,
    groom: Groom,
    body: Mesh | None,
    surface: tuple[LevelSet, ...] | None,
    parts: tuple[BodyParts, ...] | None,
    time: Time,
    prepared: "Influences",
    *,
    diameter: Annotated[Metres, Interval(ge=1e-5, le=2e-3)] = 80e-6,
    thickness: Annotated[Metres, Interval(ge=0.0, le=0.02)] = 1e-3,
) -> Strands:
    """Deform a groom by particles, with the lengths of its strands preserved.

    The groom may differ from the groom of the particles, on the same body. With `surface` or `parts`, contact moves
    strands out of them.

    diameter   diameter of a strand in pictures and exports
    thickness  distance kept from bodies, from the fifth point on; one fifth of it at the first
    """
    import numpy as np

    from hairpipe.groom.interpolating import pushed_out
    from hairpipe.particles.skinning import deformed

    shown = deformed(groom, cloud, particles, prepared, body, diameter)
    return pushed_out(shown, np.ones(len(groom.ids), bool), surface or (), parts or (), thickness, time.dt)
