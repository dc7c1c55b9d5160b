"""Hair that is pressed against an open garment, alone and over a body, stays on its side, all of every segment."""

import re
import warnings
from typing import get_type_hints

import numpy as np
import pytest

from hairpipe.body.shapes import build_cylinder
from hairpipe.geometry.collider import Collider
from hairpipe.laws.settings import BodyContact
from hairpipe.levelset.bake import bake_sheets
from hairpipe.nodes.bake_levelset import bake_levelset
from hairpipe.shot.build import MOST_VOXELS, bodies_of
from hairpipe.strands.material import Material
from hairpipe.values import LevelSet, Mesh

ROOT = np.array([0.1 / 3, 0.0, -0.1 / 3])
RADIUS, VOXEL, THICKNESS = 0.08, 0.005, 0.012
FRAME = 1 / 24
MOVING, FRAMES = 6, 24
GAP, TRAVEL = 0.09, 0.06  # from the root along X before the motion, and the motion, after which hair hangs across [m]
UP = np.array([0.5, 1.0, 0.0]) / np.hypot(0.5, 1.0)  # of the axis: the garment passes under the root
ACROSS = np.array([UP[1], -UP[0], 0.0])


def centre(side: float, gap: float) -> np.ndarray:
    """A point of the axis of a cylinder, of which a root is so far along X; side 1: outside, -1: inside."""
    return ROOT + np.array([gap, 0.0, 0.0]) + side * RADIUS * ACROSS


def panel(side: float, gap: float, rate: float) -> Mesh:
    """A third of the cylinder, open all around, that moves along X at a rate [m/s]; its winding is mixed."""
    angles = np.radians(np.linspace(-60.0, 60.0, 25))
    ring = centre(side, gap) + RADIUS * (
        np.cos(angles)[:, None] * -side * ACROSS + np.sin(angles)[:, None] * np.array([0.0, 0.0, 1.0])
    )
    points = np.concatenate([ring + height * UP for height in (-0.16, 0.06)])
    k = np.arange(24)
    triangles = np.concatenate([np.column_stack([k, k + 1, k + 25]), np.column_stack([k + 1, k + 26, k + 25])])
    triangles[::2] = triangles[::2, ::-1]
    return Mesh(points, triangles.astype(np.int32), np.tile([rate, 0.0, 0.0], (len(points), 1)))


def sides(points: np.ndarray, side: float, gap: float) -> np.ndarray:
    """Distance from the cylinder, on the root's side, of points and of nine places on each segment, (s, n, 3) [m]."""
    share = np.linspace(0.0, 1.0, 11)[:, None, None, None]
    away = (1.0 - share) * points[:, :-1] + share * points[:, 1:] - centre(side, gap)
    return side * (np.linalg.norm(away - (away @ UP)[..., None] * UP, axis=-1) - RADIUS)


def colliders(before: LevelSet, after: LevelSet) -> list[Collider]:
    return bodies_of([(before, after)], [], BodyContact(), FRAME)


@pytest.fixture
def press(scene, straight, triangle):
    """Sides at all frames of hair that a moved root presses against a garment, or through where it is if it is none."""

    def run(model: str, side: float, garment: LevelSet | None) -> np.ndarray:
        shot = scene([straight(0.1, 10, [0.0, -1.0, 0.1 * k]) for k in (-1, 0, 1)], model=model, drag=8.0)
        found = []
        for frame in range(FRAMES):
            step = TRAVEL / MOVING if frame < MOVING else 0.0
            moved = triangle(shot.body.points + np.array([step, 0.0, 0.0]), np.tile([step / FRAME, 0.0, 0.0], (3, 1)))
            shot.run(FRAME, colliders(garment, garment) if garment else (), lambda moved=moved: moved)
            found.append(sides(shot.axis.reshape(3, -1, 3), side, GAP))
        return np.array(found)

    return run


@pytest.mark.parametrize(("case", "model"), [("inside", "rod"), ("outside", "network"), ("over a body", "rod")])
def test_hair_pressed_against_a_garment_comes_to_rest_on_its_side(press, case, model):
    side = -1.0 if case == "inside" else 1.0
    body = build_cylinder(RADIUS - 0.002, 0.32, False, 48, tuple(centre(side, GAP) - 0.05 * UP), tuple(UP))
    garment = bake_sheets(
        body if case == "over a body" else None, panel(side, GAP, 0.0), VOXEL, 6.0, "refuse", THICKNESS
    )
    free, held = press(model, side, None), press(model, side, garment)
    assert free[-1].min() < -0.01  # nothing else keeps hair off the other side
    kept = 0.5 * THICKNESS + BodyContact().thickness
    assert held.min() > kept - 5e-4
    assert held[-1].min() < kept + 5e-4
    assert np.abs(held[-1] - held[-2]).max() < 1e-4


def test_a_garment_that_leaves_its_band_is_named_and_a_wider_band_holds_hair(scene, straight):
    """A sheet of 4 mm moves by 60 mm in a frame, across hair at rest."""

    def pair(half_width: float) -> list[LevelSet]:
        return [
            bake_sheets(None, panel(1.0, gap, -TRAVEL / FRAME), 0.002, half_width, "refuse", 0.004)
            for gap in (GAP, GAP - TRAVEL)
        ]

    def nearest(bodies: list[Collider]) -> float:
        shot = scene([straight(0.1, 10, [0.0, -1.0, 0.0])], model="rod")
        return sides(shot.run(FRAME, bodies).axis[None], 1.0, GAP - TRAVEL).min()

    with pytest.warns(UserWarning, match=r"level set 1 moves by 0.06 m in a frame, beyond its band") as caught:
        narrow = colliders(*pair(2.0))
    assert nearest(narrow) < -0.01
    needed = re.search(r"half_width = (\d+)", str(caught[0].message))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wide = colliders(*pair(float(needed[1])))
    assert nearest(wide) > 0.002


def test_every_level_set_that_leaves_its_band_is_named_with_what_it_needs():
    """Plates of different voxels: the farther one needs fewer of them, and the finer one more than there can be."""

    def plate(voxel: float, way: float) -> tuple[LevelSet, LevelSet]:
        corners = np.array([[0.0, y, z] for y in (-0.01, 0.01) for z in (-0.01, 0.01)])
        triangles = np.array([[0, 1, 2], [1, 3, 2]], np.int32)
        rates = np.tile([way / FRAME, 0.0, 0.0], (4, 1))
        ends = [Mesh(corners + np.array([x, 0.0, 0.0]), triangles, rates) for x in (0.0, way)]
        before, after = (bake_sheets(None, mesh, voxel, 2.0, "refuse", None) for mesh in ends)
        return before, after

    pairs = [plate(0.005, 0.01), plate(0.01, 0.39), plate(0.001, 0.2)]
    with pytest.warns(UserWarning, match="beyond its band") as caught:
        bodies_of(pairs, [], BodyContact(), FRAME)
    found = [str(warning.message) for warning in caught]
    assert [message[: message.index(" m ")] for message in found] == [
        "level set 2 moves by 0.39",
        "level set 3 moves by 0.2",
    ]
    assert "(half_width = 20, of" in found[0]
    assert "(half_width = 64, and voxel = 0.00156 or more, of" in found[1]
    (limit,) = get_type_hints(bake_levelset, include_extras=True)["half_width"].__metadata__[-1:]
    assert limit.le == MOST_VOXELS


def test_hair_of_short_segments_hangs_over_the_edge_of_a_garment(scene, straight):
    """A segment as long as the edge is thick, with the distance kept on both sides, cannot have it between its ends."""
    edge, across, thickness = -0.02, ROOT[0] + 0.03, 0.008
    points = np.array([[across, y, z] for y in (-0.25, edge) for z in (ROOT[2] - 0.06, ROOT[2] + 0.06)])
    upright = Mesh(points, np.array([[0, 1, 2], [1, 3, 2]], np.int32), np.zeros_like(points))
    garment = bake_sheets(None, upright, 0.004, 6.0, "refuse", thickness)
    segments = int(np.ceil(0.2 / (thickness + 2.0 * BodyContact().thickness)))
    shot = scene([straight(0.2, segments, [1.0, -0.1, 0.0])], Material(diameter=4e-5), model="rod", drag=8.0)
    heights = []
    for _ in range(20):
        strand = shot.run(FRAME, colliders(garment, garment)).axis
        inner = np.flatnonzero((strand[:-1, 0] < across) & (strand[1:, 0] >= across))[0]
        share = (across - strand[inner, 0]) / (strand[inner + 1, 0] - strand[inner, 0])
        heights.append(strand[inner, 1] + share * (strand[inner + 1, 1] - strand[inner, 1]) - edge)
    assert strand[-1, 1] < edge - 0.05  # it hangs on both sides
    assert min(heights) > 0.5 * thickness
