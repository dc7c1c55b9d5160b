"""Particles that represent hair."""

from typing import Annotated, Literal

from hairpipe.engine import node
from hairpipe.particles.settings import Fibre
from hairpipe.units import Fraction, Ge, Interval
from hairpipe.values import Groom, Particles


@node(frames="once")
def sample_particles(
    groom: Groom,
    *,
    particles: Annotated[int, Interval(ge=1, le=10_000_000)] = 2000,
    sampling: Literal["strands", "even"] = "strands",
    links: Annotated[int, Interval(ge=1, le=100)] = 12,
    alignment: Fraction = 0.5,
    linked: Annotated[float, Ge(1.0)] = 58.0,
    touching: Annotated[float, Ge(1.0)] = 24.0,
    fibre: Fibre = Fibre(),  # noqa: B008 (frozen)
    seed: Annotated[int, Ge(0)] = 0,
) -> Particles:
    """Sample the hair of a groom by loosely connected particles, after Bando, Chen, Nishita 2003.

    particles  approximate number of moving particles
    sampling   placement of particles: strands (along strands, with equal spacing across and along) or even (most
               uniform in space, unrelated to strands)
    links      approximate number of links of a particle
    alignment  minimum alignment of a link with the hair: 0 across, 1 along
    linked     average number of neighbours within the distance of zero link strength
    touching   average number of neighbours with forces between hair
    fibre      fibres that particles represent
    seed       seed of all random numbers
    """
    from hairpipe.particles.links import LinkRule, link
    from hairpipe.particles.sampling import sample

    return link(
        sample(groom, particles, sampling, seed), LinkRule(links, alignment, linked, touching), fibre.line_density
    )
