"""Particles that stand for hair."""

from typing import Annotated, Literal

from hairpipe.data import Groom, Particles
from hairpipe.graph import node
from hairpipe.particles.settings import Fibre
from hairpipe.units import Fraction, Ge, Interval


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
    """Loosely connected particles after Bando, Chen, Nishita 2003, in the hair of a groom; some lie below the skin.

    particles  that move; about as many
    sampling   strands: on hairs whose roots are as far apart as particles along them; even: as far apart in space as
               can be, on hairs that have nothing else in common
    links      that a particle has, about
    alignment  of the hair with a link, 0 across it and 1 along it, that it has at least
    linked     neighbours that a particle has where links have faded, on the mean
    touching   neighbours that hair acts on, on the mean
    fibre      that hair consists of
    seed       of all random numbers
    """
    from hairpipe.particles.links import LinkRule, link
    from hairpipe.particles.sampling import sample

    return link(
        sample(groom, particles, sampling, seed), LinkRule(links, alignment, linked, touching), fibre.line_density
    )
