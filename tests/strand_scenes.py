"""Strands on a single triangle that can be moved about."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from hairpipe.geometry.rotations import root_frames
from hairpipe.laws.settings import Air, Drag, Scheme, StepControl, StrainLimit
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Mesh

TRIANGLE = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, -0.1]])


def plate(points=TRIANGLE, velocities=None):
    return Mesh(np.asarray(points, float), np.array([[0, 1, 2]], np.int32), velocities)


def groom_of(strands):
    """A groom of given polylines, all bound to the middle of the triangle."""
    strands = [np.asarray(s, float) for s in strands]
    count = len(strands)
    offsets = np.concatenate([[0], np.cumsum([len(s) for s in strands])]).astype(np.int32)
    triangles = np.zeros(count, np.int32)
    middle = np.full((count, 3), 1 / 3)
    mesh = plate()
    return Groom(
        np.concatenate(strands),
        offsets,
        np.arange(count, dtype=np.int32),
        triangles,
        middle,
        root_frames(mesh.points, mesh.triangles, triangles, middle),
        np.zeros((count, 2), np.float32),
    )


def line(length, segments, direction):
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    return TRIANGLE.mean(0) + np.linspace(0, length, segments + 1)[:, None] * direction


class Solid:
    """A body that is known in closed form; a Collider.

    shape     function of points and time: distances and normals
    velocity  of the surface, or a function of points and time
    swept     whether points may be swept along it
    """

    def __init__(self, shape, velocity=(0.0, 0.0, 0.0), speed=0.0, band=np.inf, swept=True):
        self.shape, self.velocity, self.speed, self.band, self.swept = shape, velocity, speed, band, swept

    def probe(self, points, seconds, out, reach=None):
        distance, normals = self.shape(points, seconds)
        velocity = self.velocity(points, seconds) if callable(self.velocity) else self.velocity
        near = distance < np.minimum(out.distance, self.band)
        found = distance, normals, velocity
        for values, given in zip(out, found, strict=True):
            values[near] = np.broadcast_to(given, values.shape)[near]

    def sweep(self, walk, start, end, out):
        assert self.swept, "points are swept along a surface that they only probe"


def around(ways, radius):
    """Distances and normals of a ball, by the ways of points from its centre."""
    far = np.linalg.norm(ways, axis=1)
    return far - radius, ways / far[:, None]


def even_ball(centre, radius, count):
    """A ball whose corners are spread evenly, at rest."""
    i = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * i / count), np.pi * (1 + 5**0.5) * i
    unit = np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1)
    hull = ConvexHull(unit).simplices
    inwards = np.linalg.det(unit[hull]) < 0
    hull[inwards] = hull[inwards][:, ::-1]
    return Mesh(np.array(centre) + radius * unit, hull.astype(np.int32), np.zeros(unit.shape))


class Shot:
    """Hair on the plate, run frame by frame."""

    def __init__(
        self,
        strands,
        material=None,
        *,
        step=1 / 240,
        gravity=9.81,
        drag=0.0,
        fps=24.0,
        model="network",
        scheme=Scheme(),  # noqa: B008 (frozen)
    ):
        self.hair = build_hair(groom_of(strands), material or Material(), model)
        self.body = plate()
        self.scene = Scene(
            gravity, Air(Drag(drag)), steps=StepControl(longest=step), strain=StrainLimit(), scheme=scheme
        )
        self.state = start(self.hair, self.body, self.scene)
        self.frame = 1 / fps

    def run(self, seconds, bodies=(), body=None):
        for _ in range(round(seconds / self.frame)):
            after = body() if body else self.body
            self.state = advance_frame(self.hair, self.state, (self.body, after), bodies, self.frame, self.scene)
            self.body = after
        return self

    @property
    def points(self):
        return strands_of(self.hair, self.state).points.astype(float)

    @property
    def axis(self):
        return self.hair.layout.axis(self.state.positions)


@pytest.fixture
def scene():
    return Shot


@pytest.fixture
def straight():
    return line


@pytest.fixture
def triangle():
    return plate
