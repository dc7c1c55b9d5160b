"""A shaking head of hair: what the bench `contact` measures."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from hairpipe.body.bust import build_bust
from hairpipe.body.skinning import skin
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Style
from hairpipe.laws.settings import Collisions, Locks, StepControl, Stiction, Volume
from hairpipe.levelset.bake_parts import bake_parts
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import next_state, start
from hairpipe.strands.hair_model import HairModel, build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Body, BodyParts, Mesh, Pose
from hairpipe.values.hair import HairState
from hairpipe.values.painting import Canvas, PaintedMetres

Between = Literal["pairs", "locks", "volume", "nothing"]
"""What hair does to hair: stick and collide pair by pair, the same in locks, act on a grid, or pass through."""
FPS, STEPS = 24.0, 10
"""Frames a second, steps a frame."""
LENGTH, SEGMENTS = 0.25, 50
"""Length of the hair [m] and segments of a strand."""
TURN = np.radians(60.0)
FREQUENCY = 1.5
"""Yaw [rad], so often a second [Hz]."""
VOXEL, HALF_WIDTH, SMALLEST = 0.005, 8.0, 0.08
"""Level sets: the spacing of samples [m], the band [voxels], the smallest part [m]."""


@dataclass(eq=False)
class Head:
    """A bust that turns to and fro, and its hair."""

    bust: Body
    hair: HairModel
    state: HairState
    scene: Scene
    frame: int = 0

    def surroundings(self) -> Frame:
        """Make what the next frame is simulated in: what nodes before the hair make of it."""
        at = self.frame / FPS, (self.frame + 1) / FPS
        before, after = (parts_at(self.bust, seconds) for seconds in at)
        meshes = mesh_at(self.bust, at[0]), mesh_at(self.bust, at[1])
        return Frame(meshes, (), ((before, after),), at[0], 1 / FPS)

    def advance(self, frame: Frame) -> None:
        """Simulate the next frame, in place."""
        self.state = next_state(self.hair, self.state, frame, self.scene)
        self.frame += 1


def scene_of(between: Between) -> Scene:
    """Return a scene with all that bodies do to hair, and what hair does to hair."""
    steps = StepControl(longest=1 / (FPS * STEPS), root=1.0, travel=1.0, crossings=1.0)
    scene = Scene(steps=steps)
    if between == "volume":
        return replace(scene, volume=Volume())
    if between == "nothing":
        return scene
    locks = Locks() if between == "locks" else None
    return replace(scene, stiction=Stiction(), collisions=Collisions(), locks=locks)


def grow_head(segments: int, between: Between) -> Head:
    """Grow a head of long straight hair with about so many segments in all."""
    bust = build_bust()
    style = Style(length=PaintedMetres(LENGTH))
    groom = grow(Canvas(bust, no_image, 0), style, None, max(segments // SEGMENTS, 1), Cut(SEGMENTS))
    hair = build_hair(groom, Material(), "network")
    scene = scene_of(between)
    return Head(bust, hair, start(hair, mesh_at(bust, 0.0), scene), scene)


def no_image(path: Path) -> np.ndarray:
    """Refuse to read a picture: nothing here is painted."""
    raise FileNotFoundError(path)


def pose_at(bust: Body, seconds: float) -> Pose:
    """Turn all of the bust about the vertical through its root."""
    phase = 2.0 * np.pi * FREQUENCY * seconds
    angle = TURN * np.sin(phase)
    rate = TURN * 2.0 * np.pi * FREQUENCY * np.cos(phase)
    c = np.cos(angle)
    s = np.sin(angle)
    turn = np.eye(4)
    spin = np.zeros((4, 4))
    turn[0, 0] = c
    turn[0, 2] = s
    turn[2, 0] = -s
    turn[2, 2] = c
    spin[0, 0] = -s * rate
    spin[0, 2] = c * rate
    spin[2, 0] = -c * rate
    spin[2, 2] = -s * rate
    return Pose(turn @ bust.skeleton.rest, spin @ bust.skeleton.rest)


def mesh_at(bust: Body, seconds: float) -> Mesh:
    """Return the skin of the bust at a time [s]."""
    return skin(bust, pose_at(bust, seconds))


def parts_at(bust: Body, seconds: float) -> BodyParts:
    """Return the parts of the bust at a time [s]; all are rigid: samples are baked once."""
    return bake_parts(bust, pose_at(bust, seconds), VOXEL, HALF_WIDTH, SMALLEST)
