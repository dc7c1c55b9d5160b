"""A bundle of straight hairs that stick to each other, on a triangle."""

import numpy as np

from hairpipe.geometry.rotations import root_frames
from hairpipe.laws.settings import Collisions, Locks, Stiction
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import next_state
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Mesh

SEGMENTS, SIDE, SPACING = 8, 5, 4e-4
CORNERS = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, -0.1]])
SCENE = Scene(stiction=Stiction(), collisions=Collisions(), locks=Locks(after=2, most=8, tolerance=1e-3))


def build_bundle(model="network", seed=None):
    """A bundle of straight hairs that stick out of a triangle, near enough to each other to stick.

    With a seed, its points are a picometre elsewhere: another rounding of the same hair.
    """
    places = SPACING * np.stack(np.meshgrid(*[np.arange(SIDE)] * 2), -1).reshape(-1, 2)
    roots = np.stack([0.03 + places[:, 0], np.zeros(len(places)), -0.03 - places[:, 1]], 1)
    points = roots[:, None] + np.linspace(0.0, 0.06, SEGMENTS + 1)[:, None] * np.array([0.6, 0.8, 0.0])
    if seed is not None:
        points = points + 1e-12 * np.random.default_rng(seed).standard_normal(points.shape)
    count, weights = (
        len(roots),
        np.stack([1.0 - 10.0 * (roots[:, 0] - roots[:, 2]), 10.0 * roots[:, 0], -10.0 * roots[:, 2]], 1),
    )
    triangles = np.zeros(count, np.int32)
    frames = root_frames(CORNERS, np.array([[0, 1, 2]], np.int32), triangles, weights)
    offsets = np.arange(0, count * (SEGMENTS + 1) + 1, SEGMENTS + 1, dtype=np.int32)
    ids = np.arange(count, dtype=np.int32)
    groom = Groom(points.reshape(-1, 3), offsets, ids, triangles, weights, frames, np.zeros((count, 2), np.float32))
    return build_hair(groom, Material(), model)


def body(time):
    """The triangle, shaken from side to side."""
    way = np.array([0.01 * np.sin(12.0 * time), 0.0, 0.0])
    speed = np.tile([0.12 * np.cos(12.0 * time), 0.0, 0.0], (3, 1))
    return Mesh(CORNERS + way, np.array([[0, 1, 2]], np.int32), speed)


def shot(hair, scene, frames, state=None, first=0, driver=body, surfaces=()):
    states, dt = [] if state is None else [state], 1 / 24
    for f in range(first, first + frames):
        drivers = driver(max(f - 1, 0) * dt), driver(f * dt)
        state = next_state(hair, state, Frame(drivers, surfaces, (), max(f - 1, 0) * dt, dt), scene)
        states.append(state)
    return states
