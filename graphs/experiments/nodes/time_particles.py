"""The cost of a simulation of hair as particles."""

from typing import Annotated

from hairpipe.data import BodyParts, LevelSet, Mesh, Particles, Table
from hairpipe.graph import Cuts, Frames, Time, flat_group, node
from hairpipe.particles.settings import ParticleSettings
from hairpipe.units import Ge


@node(frames="once")
@flat_group("settings")
def time_particles(
    particles: Particles,
    body: Frames[Mesh] | None,
    surface: tuple[Frames[LevelSet], ...] | None,
    parts: tuple[Frames[BodyParts], ...] | None,
    time: Time,
    cuts: Cuts,
    *,
    settings: ParticleSettings,
    warm: Annotated[int, Ge(1)] = 4,
    timed: Annotated[int, Ge(1)] = 12,
) -> Table:
    """Processor seconds per frame of a simulation by particles on one thread, as `time_hair` has them of strands.

    It takes the inputs and settings of `simulate_particles`: `like = "cloud"`, `type = "time_particles"`.

    warm   frames before those that count
    timed  frames that count
    """
    from hairpipe.measure.cost import Around, cost_table, particle_advance

    around = Around(body, None, surface or (), parts or (), cuts)
    frames = around.frames(time.frame, 1 + warm + timed)
    advance = particle_advance(particles, around, settings, time.dt)
    return cost_table(advance, frames, len(particles.points), warm, timed)
