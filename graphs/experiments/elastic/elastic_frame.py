"""A body of springs from frame to frame."""

from math import floor

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.elastic.elastic_settings import ElasticScene
from hairpipe.graphs.experiments.elastic.elastic_stage import Body
from hairpipe.graphs.experiments.elastic.elastic_values import ElasticState
from hairpipe.graphs.experiments.elastic.spring_assembly import find_forces, spring_energy
from hairpipe.graphs.experiments.elastic.spring_mesh import Springs
from hairpipe.graphs.experiments.elastic.time_stepping import SCHEMES

_ROUNDING = 1e-6
"""Of steps since springs act: times are sums."""


def begin(springs: Springs, points: np.ndarray, scene: ElasticScene) -> ElasticState:
    """Put a body where its points are, (n, 3) [m]."""
    count = len(points)
    velocities = np.zeros((count, 3))
    if scene.stir:
        random = np.random.default_rng(scene.stir.seed)
        velocities = scene.stir.speed * random.normal(size=(count, 3)) * springs.free
    acting = springs if scene.slack == 0 else _limp(springs)
    pull = np.zeros((count, 3))
    find_forces(pull, points, acting)
    pull /= springs.mass[:, None]
    acceleration = (pull - scene.gravity * np.array([0.0, 1.0, 0.0]) - scene.drag * velocities) * springs.free
    still = np.zeros(len(springs.pairs)), np.zeros(count)
    energy = _energy(acting, points, velocities, scene)
    return ElasticState(0.0, points.copy(), velocities, acceleration, *still, energy)


def advance_frame(
    springs: Springs, state: ElasticState, frame: float, scene: ElasticScene, damping: float
) -> ElasticState:
    """Advance a body by a frame [s].

    damping  time over which stiffness damps [s]

    Raises BadInput where it does not stay finite.
    """
    body = Body(
        springs,
        state.positions,
        state.velocities,
        state.accelerations,
        state.tensions.copy(),
        state.pressed.copy(),
        damping,
        scene.drag,
        scene.gravity,
        scene.ground.friction if scene.ground else None,
    )
    dt = frame / scene.steps
    limp = _limp(springs)
    for step in range(scene.steps):
        since = floor((state.time - scene.slack) / dt + step + 1.5 + _ROUNDING)
        body.springs = springs if since > 0 else limp
        # The acceleration knows nothing of springs that begin to act now.
        begins = scene.slack > 0.0 and since == 1
        SCHEMES["backward_euler" if begins else scene.scheme](body, dt)
    time = state.time + frame
    lost = np.flatnonzero(~np.isfinite(body.x).all(axis=1))
    if len(lost):
        raise BadInput(f"particle {lost[0]} and {len(lost) - 1} more diverged before {time:.3f} s", right="more steps")
    energy = _energy(body.springs, body.x, body.v, scene)
    return ElasticState(time, body.x, body.v, body.a, body.T, body.pressed, energy)


def _limp(springs: Springs) -> Springs:
    """Return springs that do nothing."""
    return springs._replace(pulls=0 * springs.pulls, presses=0 * springs.presses)


def _energy(springs: Springs, x: np.ndarray, v: np.ndarray, scene: ElasticScene) -> np.ndarray:
    kinetic = np.sum(springs.mass[:, None] * v**2) / 2
    return np.array([kinetic, spring_energy(x, springs), scene.gravity * np.sum(springs.mass * x[:, 1])])
