"""Simulation of a solid of tetrahedra."""

from typing import NamedTuple

from hairpipe.engine import Time, flat_group, node
from hairpipe.graphs.experiments.elastic.elastic_settings import ElasticScene
from hairpipe.graphs.experiments.elastic.elastic_values import ElasticState, Solid
from hairpipe.graphs.experiments.elastic.matter import Rubber
from hairpipe.values import Mesh


class MovingSolid(NamedTuple):
    """Surface of a frame, and the state from which the next frame starts."""

    mesh: Mesh
    state: ElasticState


@node(frames="scan")
@flat_group("scene")
def simulate_solid(
    solid: Solid,
    start: Solid | None,
    previous: ElasticState | None,
    time: Time,
    *,
    matter: Rubber = Rubber(),  # noqa: B008 (frozen)
    scene: ElasticScene,
) -> MovingSolid:
    """Simulate springs on the tetrahedra of `solid` from the shape `start`, after Selle, Lentine, Fedkiw 2008.

    matter   material of the solid, which determines the spring constants
    """
    from hairpipe.graphs.experiments.elastic.elastic_frame import advance_frame, begin
    from hairpipe.graphs.experiments.elastic.hinges import boundary
    from hairpipe.graphs.experiments.elastic.spring_mesh import solid_springs

    springs = solid_springs(solid, matter)
    if previous is None:
        state = begin(springs, (start or solid).points, scene)
    else:
        state = advance_frame(springs, previous, time.dt, scene, matter.damping)
    return MovingSolid(Mesh(state.positions, boundary(solid.tetrahedra), state.velocities), state)
