"""A curtain of straight hair that hangs from a plate, which can be moved about, and bodies known exactly."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from hairpipe.geometry.rotations import root_frames
from hairpipe.particles.links import LinkRule, link
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Fibre, ParticleSettings
from hairpipe.particles.simulate import ParticleSimulation, advance_frame, prepare, start
from hairpipe.shot.shot import Frame
from hairpipe.values import Groom, Mesh
from hairpipe.values.hair import ParticleState

from ..strand_scenes import Solid, around

RULE = LinkRule(12, 0.5, 58.0, 24.0)
FRAME = 1 / 24
HALF, DEPTH, LENGTH = 0.1, 0.03, 0.2
"""Half the width of the curtain, half its depth, and the length of its hair [m]."""


NO_TURN = np.eye(3)


def plate(way=(0.0, 0.0, 0.0), turn=NO_TURN, velocities=None):
    """A large triangle that faces down, turned about the origin and moved [m]."""
    corners = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 2.0]])
    return Mesh(corners @ np.asarray(turn).T + way, np.array([[0, 1, 2]], np.int32), velocities)


def groom_of(strands):
    """A groom of given polylines on the plate."""
    counts = [len(strand) for strand in strands]
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    points, triangles = np.concatenate(strands).astype(float), np.zeros(len(strands), np.int32)
    mesh = plate()
    a, b, c = mesh.points
    inside = np.linalg.solve(np.stack([b - a, c - a], axis=1)[[0, 2]], (points[offsets[:-1]] - a)[:, [0, 2]].T).T
    where = np.column_stack([1.0 - inside.sum(axis=1), inside])
    frames = root_frames(mesh.points, mesh.triangles, triangles, where)
    ids = 10 + np.arange(len(strands), dtype=np.int32)
    return Groom(points, offsets, ids, triangles, where, frames, np.zeros((len(strands), 2), np.float32))


def make_curtain(count=1000):
    rng = np.random.default_rng(7)
    roots = np.column_stack([rng.uniform(-HALF, HALF, count), np.zeros(count), rng.uniform(-DEPTH, DEPTH, count)])
    down = np.linspace(0.0, LENGTH, 41)[:, None] * (0.0, -1.0, 0.0)
    return groom_of([root + down for root in roots])


def make_ball(centre, velocity, radius=0.04):
    """A ball that moves straight, which particles probe, and do not sweep along."""
    speed = float(np.linalg.norm(velocity))
    return Solid(lambda x, t: around(x - centre - t * velocity, radius), velocity, speed, band=0.02, swept=False)


class Shot:
    """Particles in the curtain, frame by frame."""

    def __init__(self, particles, **settings):
        self.particles, self.settings = particles, ParticleSettings(**settings)
        self.prepared, self.body = prepare(particles, self.settings), plate()
        self.simulation = ParticleSimulation(particles, self.prepared, self.settings)
        self.state = start(self.simulation, Frame((plate(), plate()), (), (), 0.0, FRAME), ())

    def run(self, frames, body=None, bodies=(), kick=None):
        """Go on; body gives the plate, bodies the colliders, and kick what is added to velocities, by the frame."""
        for frame in range(frames):
            after = self.body if body is None else body(frame)
            if kick is not None:
                self.state = replace(self.state, velocities=self.state.velocities + kick(frame))
            given = Frame((self.body, after), (), (), 0.0, FRAME)
            solid = bodies(frame) if callable(bodies) else bodies
            self.state = advance_frame(self.simulation, self.state, given, solid)
            self.body = after
        return self

    @property
    def out(self) -> float:
        """Share of the links that are out of reach."""
        ends, points = self.particles.links, self.state.points
        far = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1) > 2.0 * self.particles.reach
        return float(far.mean())

    @property
    def pace(self) -> float:
        """Root mean square of the speeds [m/s]."""
        return float(np.sqrt(np.mean(np.sum(self.state.velocities**2, axis=1))))

    @property
    def crowding(self) -> float:
        """1 % quantile of the distance to the nearest other particle, over that at rest."""
        now, rest = (KDTree(x).query(x, k=2)[0][:, 1] for x in (self.state.points, self.particles.points))
        return float(np.quantile(now, 0.01) / np.quantile(rest, 0.01))


def copy_of(state: ParticleState) -> bytes:
    return b"".join(
        np.ascontiguousarray(getattr(state, name)).tobytes()
        for name in ("points", "velocities", "directions", "tensions")
    )


@pytest.fixture(scope="session")
def curtain() -> Groom:
    return make_curtain()


@pytest.fixture(scope="session")
def particles(curtain):
    return link(sample(curtain, 500, "strands", 0), RULE, Fibre().line_density)


@pytest.fixture
def shot(particles):
    return lambda **settings: Shot(particles, **settings)
