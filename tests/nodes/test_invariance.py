"""A shot that is shifted in time or space, that begins later or is cut has the same hair, apart from the shift."""

from typing import NamedTuple

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track
from hairpipe.body.shapes import build_box
from hairpipe.engine import Pair, Time
from hairpipe.geometry.rotations import root_frames
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.groom.sampling import thinned
from hairpipe.laws.settings import Collisions, Construction, Locks, Rest, Share, Stiction, StrainLimit, Volume
from hairpipe.levelset.bake import bake
from hairpipe.nodes.carry_strands import carry_strands, weigh
from hairpipe.nodes.interpolate_hair import interpolate_hair
from hairpipe.nodes.move_levelset import move_levelset
from hairpipe.nodes.move_mesh import move_mesh
from hairpipe.nodes.sample_particles import sample_particles
from hairpipe.nodes.simulate_hair import model_strands, simulate_hair
from hairpipe.nodes.simulate_particles import prepare_particles, simulate_particles
from hairpipe.particles.settings import Interaction, ParticleSettings, RestTension
from hairpipe.strands.material import Material
from hairpipe.values import Groom, Mesh

FPS, STILL, CUT, FRAMES = 24.0, 3, 7, 10
SPEED = np.array([0.4, 0.0, 0.1])  # [m/s]
SHIFT, TURN = np.array([3.0, 2.0, -4.0]), 70.0
TURNS = [
    np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) for c, s in ((1.0, 0.0), (0.342020143326, 0.939692620786))
]
PLATE = Mesh(np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 2.0]]), np.array([[0, 1, 2]], np.int32))
BOX = build_box((0.04, 0.04, 0.04), (-0.023, -0.07, 0.0))
STILL_BOX = bake(BOX, 0.005, 4.0, "fill")


class Take(NamedTuple):
    """A plate that stands still and then moves steadily: from which frame on, where, whether it leaps."""

    first: int = 1
    still: int = STILL
    place: np.ndarray = np.zeros(3)
    leaps: bool = False
    cut: bool = False

    @property
    def motion(self) -> Track:
        """The way of the plate, in time since the first frame."""
        frames = np.array([0, self.still, self.still + CUT - STILL - 1, self.still + CUT - STILL, FRAMES])
        ways = np.maximum(frames - self.still, 0)[:, None] / FPS * SPEED
        turns = np.array([0.0, 0.0, 0.0, TURN, TURN]) * self.leaps
        moves = [TURNS[int(turn > 0.0)] @ way + SHIFT * (turn > 0.0) for turn, way in zip(turns, ways, strict=True)]
        keys = {"move": tuple(map(tuple, moves + self.place)), "turn": tuple(turns), "axis": (0.0, 1.0, 0.0)}
        return Track(tuple(frames / FPS), **keys, ease="linear")


@pytest.fixture(scope="module")
def groom() -> Groom:
    """Hairs that hang from the plate in a bundle, a little bent."""
    x, z = (1.2e-3 * grid.ravel() for grid in np.meshgrid(np.arange(5), np.arange(4)))
    roots, down = np.stack([x, 0.0 * x, z], axis=1), np.linspace(0.0, 0.1, 7)[:, None]
    points = roots[:, None] + np.concatenate([0.2 * down, -down, 2.0 * down**2], axis=1)
    a, b, c = PLATE.points
    inside = np.linalg.solve(np.stack([b - a, c - a], axis=1)[[0, 2]], (roots - a)[:, [0, 2]].T).T
    where = np.column_stack([1.0 - inside.sum(axis=1), inside])
    count, triangles = len(roots), np.zeros(len(roots), np.int32)
    frames = root_frames(PLATE.points, PLATE.triangles, triangles, where)
    offsets = np.arange(0, 7 * count + 1, 7, dtype=np.int32)
    ids = np.arange(count, dtype=np.int32)
    return Groom(points.reshape(-1, 3), offsets, ids, triangles, where, frames, np.zeros((count, 2), np.float32))


def frames_of(take: Take, step) -> list:
    """Simulate a take: the strands of every frame; `step(pair of bodies, pair of parts, state, time, cuts)`."""
    cuts = (take.first + take.still + CUT - STILL,) if take.cut else ()
    shown, state, before = [], None, None
    for frame in range(take.first, take.first + take.still + FRAMES - STILL):
        time = Time(frame, FPS)
        body = move_mesh(PLATE, time, cuts, at=take.first, motion=take.motion)
        parts = move_levelset(STILL_BOX, time, cuts, at=take.first, motion=take.motion)
        whole = bake(move_mesh(BOX, time, cuts, at=take.first, motion=take.motion), 0.005, 4.0, "fill")
        before = before or (body, parts, whole)
        now = tuple(cut for cut in cuts if cut == frame)
        strands, state = step(Pair(before[0], body), (Pair(before[1], parts), Pair(before[2], whole)), state, time, now)
        shown, before = [*shown, strands], (body, parts, whole)
    return shown


def strands_by(groom: Groom, model: str = "network", bodies: str = "", **settings):
    rest = Rest(balanced=Share(1.0), unstable="settle")
    prepared = model_strands(groom, Material(), model, Construction(), rest)
    settings = {"model": model, "precision": "double", "rest": rest, **settings}

    def step(body, box, state, time, cuts):
        parts, whole = ((pair,) if name == bodies else None for name, pair in zip(("parts", "whole"), box, strict=True))
        return simulate_hair(groom, body, whole, parts, None, None, None, state, time, cuts, prepared, **settings)

    return step


def particles_by(groom: Groom):
    particles = sample_particles(groom, particles=75)
    settings = ParticleSettings(interaction=Interaction(), sag_free=RestTension())
    hair = [getattr(settings, name) for name in ("sag", "damping", "gravity", "interaction", "sag_free", "printed")]
    prepared, influences = prepare_particles(particles, *hair), weigh(particles, groom)

    def step(body, box, state, time, cuts):
        given = {"interaction": settings.interaction, "sag_free": settings.sag_free}
        hair = simulate_particles(particles, body, None, None, state, time, cuts, prepared, **given)
        return carry_strands(hair.cloud, particles, groom, body.current, None, None, time, influences), hair.state

    return step


def keys_by(groom: Groom):
    keys = thinned(groom, 4)
    simulate, weights = strands_by(keys), weigh_keys(keys, groom, 30.0)

    def step(body, box, state, time, cuts):
        hair, state = simulate(body, box, state, time, cuts)
        return interpolate_hair(hair, keys, groom, None, body.current, None, None, None, time, weights), state

    return step


TOUCHING = {"stiction": Stiction(), "collisions": Collisions(), "strain": StrainLimit()}
MODELS = {
    "network": strands_by,
    "rod": lambda groom: strands_by(groom, "rod"),
    "whole": lambda groom: strands_by(groom, bodies="whole"),
    "parts": lambda groom: strands_by(groom, bodies="parts"),
    "contact": lambda groom: strands_by(groom, **TOUCHING),
    "volume": lambda groom: strands_by(groom, volume=Volume()),
    "locks": lambda groom: strands_by(groom, **TOUCHING, locks=Locks(after=2, tolerance=1e-3)),
    "keys": keys_by,
    "particles": particles_by,
}


FLOOR = 1e-8
"""The rounding of places after a few frames, and two instants of a track on its way [m]."""
FLOORS = {"volume": 5e-4, "particles": 1e-3, "whole": 1e-3}
"""More: a grid and a level set are fixed in the world, and particles magnify a rounding 1e5 times in these frames."""


@pytest.fixture
def floor(request) -> float:
    return FLOORS.get(request.node.callspec.params["shoot"], FLOOR)


@pytest.fixture(scope="module", params=MODELS)
def shoot(request, groom):
    """Simulate takes by a model."""
    step = MODELS[request.param](groom)
    return lambda **take: frames_of(Take(**take), step)


@pytest.fixture(scope="module")
def plain(shoot):
    """The take that others are compared with."""
    return shoot()


def apart(takes, others, turn=TURNS[0], shift=0.0) -> tuple[float, float]:
    """Largest difference of points [m] and of velocities [m/s] of takes, turned and shifted, from others."""
    found = [
        (
            np.abs(one.points @ turn.T + shift - other.points).max(),
            np.abs(one.velocities @ turn.T - other.velocities).max(),
        )
        for one, other in zip(takes, others, strict=True)
    ]
    return tuple(np.max(found, axis=0))


def test_other_frame_numbers_change_no_bit(plain, shoot):
    for one, other in zip(plain, shoot(first=1001), strict=True):
        assert one.points.tobytes() == other.points.tobytes()
        assert one.velocities.tobytes() == other.velocities.tobytes()


def test_another_place_is_a_shift(plain, shoot, floor):
    assert apart(plain, shoot(place=SHIFT), shift=SHIFT) < (floor, 100.0 * floor)


@pytest.mark.parametrize("shoot", [name for name in MODELS if name != "particles"], indirect=True, scope="module")
def test_hair_that_is_at_rest_may_begin_later(plain, shoot):
    """Particles are not at rest as groomed."""
    assert apart(plain[STILL - 1 :], shoot(still=1)) < (FLOOR, 100.0 * FLOOR)


def test_over_a_cut_hair_continues(plain, shoot, floor):
    """The plate leaps by 5 m and turns by 70 degrees; without the cut, hair leaves it at 50 m/s."""
    leapt = shoot(leaps=True, cut=True)
    assert apart(plain[:CUT], leapt[:CUT]) < (FLOOR, 100.0 * FLOOR)
    assert apart(plain[CUT:], leapt[CUT:], TURNS[1], SHIFT) < (floor, 100.0 * floor)
    assert max(np.abs(hair.velocities).max() for hair in leapt) < 1.0
