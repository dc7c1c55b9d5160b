"""Simulation of hair by particles."""

from typing import TYPE_CHECKING, NamedTuple

from hairpipe.engine import Cuts, Pair, Time, flat_group, node
from hairpipe.particles.settings import Interaction, ParticleSettings, Printed, RestTension
from hairpipe.values import BodyParts, Cloud, LevelSet, Mesh, Particles
from hairpipe.values.hair import ParticleState

if TYPE_CHECKING:
    from hairpipe.particles.simulate import Prepared


class LooseHair(NamedTuple):
    """Particles of a frame, and the state from which the next frame starts."""

    cloud: Cloud
    state: ParticleState


def prepare_particles(
    particles: Particles,
    sag: float,
    damping: float,
    gravity: float,
    interaction: Interaction | None,
    sag_free: RestTension | None,
    printed: tuple[Printed, ...],
) -> "Prepared":
    """Compute properties of links and pairs, for the whole shot."""
    from hairpipe.particles.simulate import prepare

    hair = {"interaction": interaction, "sag_free": sag_free, "printed": printed}
    return prepare(particles, ParticleSettings(sag, damping, gravity=gravity, **hair))


@node(frames="scan", prepare=prepare_particles)
@flat_group("settings")
def simulate_particles(
    particles: Particles,
    body: Pair[Mesh] | None,
    surface: tuple[Pair[LevelSet], ...] | None,
    parts: tuple[Pair[BodyParts], ...] | None,
    previous: ParticleState | None,
    time: Time,
    cuts: Cuts,
    prepared: "Prepared",
    *,
    settings: ParticleSettings,
) -> LooseHair:
    """Simulate hair as loosely connected particles after Bando, Chen, Nishita 2003, for `carry_strands`."""
    from hairpipe.particles.simulate import ParticleSimulation, cloud_of
    from hairpipe.shot.shot import Frame, next_state

    began = (time.frame - 1) * time.dt
    cut = time.frame in cuts
    frame = Frame(body or (None, None), surface or (), parts or (), began, time.dt, cut)
    state = next_state(ParticleSimulation(particles, prepared, settings), previous, frame)
    return LooseHair(cloud_of(state), state)
