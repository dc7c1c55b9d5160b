"""Simulation of a shell of triangles."""

from typing import NamedTuple

from hairpipe.engine import Time, flat_group, node
from hairpipe.graphs.experiments.elastic.elastic_settings import ElasticScene
from hairpipe.graphs.experiments.elastic.elastic_values import ElasticState, Shell
from hairpipe.graphs.experiments.elastic.matter import Fabric
from hairpipe.values import Mesh


class MovingShell(NamedTuple):
    """Triangles of a frame, and the state from which the next frame starts."""

    mesh: Mesh
    state: ElasticState


@node(frames="scan")
@flat_group("scene")
def simulate_shell(
    shell: Shell,
    previous: ElasticState | None,
    time: Time,
    *,
    matter: Fabric = Fabric(),  # noqa: B008 (frozen)
    scene: ElasticScene,
) -> MovingShell:
    """Simulate edge, bending and altitude springs on triangles, after Selle, Lentine, Fedkiw 2008.

    matter   material of the shell, which determines the spring constants
    """
    from hairpipe.graphs.experiments.elastic.elastic_frame import advance_frame, begin
    from hairpipe.graphs.experiments.elastic.spring_mesh import shell_springs

    springs = shell_springs(shell, matter)
    if previous is None:
        state = begin(springs, shell.points, scene)
    else:
        state = advance_frame(springs, previous, time.dt, scene, matter.damping)
    return MovingShell(Mesh(state.positions, shell.triangles, state.velocities), state)
