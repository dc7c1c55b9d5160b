"""A solid of tetrahedra that moves."""

from typing import Annotated, NamedTuple

from hairpipe.data import ElasticState, Mesh, Solid
from hairpipe.graph import Time, node
from hairpipe.sim.elastic.elastic_settings import Ground, Scheme, Stir, Surroundings
from hairpipe.sim.elastic.matter import Rubber
from hairpipe.units import Interval, MetresPerSecondSquared, PerSecond, Seconds


class MovingSolid(NamedTuple):
    """Its surface to look at, and the state the next frame starts from."""

    mesh: Mesh
    state: ElasticState


@node(frames="scan")
def simulate_solid(
    solid: Solid,
    start: Solid | None,
    previous: ElasticState | None,
    time: Time,
    *,
    matter: Rubber = Rubber(),  # noqa: B008 (frozen)
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
    drag: Annotated[PerSecond, Interval(ge=0.0, le=1000.0)] = 0.0,
    ground: Ground | None = None,
    stir: Stir | None = None,
    slack: Annotated[Seconds, Interval(ge=0.0, le=1e6)] = 0.0,
    steps: Annotated[int, Interval(ge=1, le=100_000)] = 10,
    scheme: Scheme = "tr_bdf2",
) -> MovingSolid:
    """Edge and altitude springs on tetrahedra, at rest in `solid`, which begin in `start`; Selle, Lentine, Fedkiw 2008.

    matter   the solid is of; the spring constants follow from it
    gravity  along -Y
    drag     rate at which still air takes away speed
    ground   it falls on; without one it falls for ever
    stir     random velocities to start with
    slack    time before which no spring acts
    steps    of equal length in a frame
    scheme   tr_bdf2 of second order, or backward_euler, which damps
    """
    from hairpipe.sim.elastic.elastic_frame import advance_frame, begin
    from hairpipe.sim.elastic.hinges import boundary
    from hairpipe.sim.elastic.spring_mesh import solid_springs

    springs = solid_springs(solid, matter)
    scene = Surroundings(gravity, drag, slack, steps, scheme, ground, stir)
    if previous is None:
        state = begin(springs, (start or solid).points, scene)
    else:
        state = advance_frame(springs, previous, time.dt, scene, matter.damping)
    return MovingSolid(Mesh(state.positions, boundary(solid.tetrahedra), state.velocities), state)
