"""Failures of a tuft of particles under a driven bar, by speed and step size."""

from typing import TYPE_CHECKING, Annotated

from hairpipe.engine import node
from hairpipe.particles import settings as of
from hairpipe.units import Gt, Interval, MetresPerSecond, Seconds
from hairpipe.values import Table

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.studies.contact.worst import Worst

Rates = tuple[Annotated[int, Interval(ge=24, le=1_000_000)], ...]
Speeds = tuple[Annotated[MetresPerSecond, Gt(0.0)], ...]


@node(frames="once")
def measure_cloud_clash(
    truth: Table | None = None,
    *,
    particles: Annotated[int, Interval(ge=10, le=600)] = 240,
    sag: Annotated[float, Interval(gt=1e-3, le=1.0)] = 0.1,
    interaction: of.Interaction | None = None,
    sag_free: of.RestTension | None = None,
    speeds: Speeds = (0.5, 1.0, 2.0, 4.0, 8.0),
    rates: Rates = (24, 48, 120, 240, 480),
    seconds: Annotated[Seconds, Gt(0.0)] = 0.5,
) -> Table:
    """Measure the quantities of `measure_clash` for particles in the same tuft, with one step per frame.

    The stretch is that of the link that holds a particle, over its length in the groom.

    particles    approximate number of moving particles
    sag          strain at the root of hanging hair of mean length
    interaction  forces between particles of hair; if absent, there are none
    sag_free     equilibrium of the groom at the start, by pre-tension of links
    speeds       speeds of the bar at contact; roots follow at a quarter of it
    rates        numbers of frames per second
    seconds      duration of the run: contacts at 1/8 s and 3/8 s, rest from 1/2 s on
    """
    from hairpipe.graphs.experiments.studies.contact.bar import tuft
    from hairpipe.graphs.experiments.studies.contact.clash import clash_table
    from hairpipe.graphs.experiments.studies.contact.cloud_clash import meet
    from hairpipe.particles.links import LinkRule, link
    from hairpipe.particles.sampling import sample

    settings = of.ParticleSettings(sag, interaction=interaction, sag_free=sag_free)
    rule = LinkRule(12, 0.5, 58.0, 24.0)
    line_density = settings.fibre.line_density
    cloud = link(sample(tuft(), particles, "strands", 0), rule, line_density)

    def run(speed: float, rate: int) -> "Worst":
        return meet(cloud, settings, speed, rate, seconds)

    return clash_table(truth, run, speeds, rates)
