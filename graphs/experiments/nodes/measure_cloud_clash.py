"""A bar driven through a tuft of particles, at which speed and in which steps."""

from typing import TYPE_CHECKING, Annotated

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.particles import settings as of
from hairpipe.units import Gt, Interval, MetresPerSecond, Seconds

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
    """What `measure_clash` measures, of particles in the same tuft, whose frames are of one step each.

    Stretched is the link that holds a particle, over its length in the groom.

    particles    that move; about as many
    sag          by which hair of mean length that hangs is stretched at its root
    interaction  hair acts on hair; without, it passes through
    sag_free     links carry the hair as groomed
    speeds       of the bar, where it meets the hair; roots go along it at a quarter of that
    rates        frames a second
    seconds      from the start; they meet after 1/8 s, and again 1/4 s later, and stand still after 1/2 s
    """
    from hairpipe.graphs.experiments.studies.contact.bar import tuft
    from hairpipe.graphs.experiments.studies.contact.clash import clash_table
    from hairpipe.graphs.experiments.studies.contact.cloud_clash import meet

    from hairpipe.particles.links import LinkRule, link
    from hairpipe.particles.sampling import sample

    settings = of.ParticleSettings(sag, interaction=interaction, sag_free=sag_free)
    rule, line_density = LinkRule(12, 0.5, 58.0, 24.0), settings.fibre.line_density
    cloud = link(sample(tuft(), particles, "strands", 0), rule, line_density)

    def run(speed: float, rate: int) -> "Worst":
        return meet(cloud, settings, speed, rate, seconds)

    return clash_table(truth, run, speeds, rates)
