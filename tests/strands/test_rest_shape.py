"""Hair that is combed into an arc and straighter at rest, without gravity: where it comes to rest."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Air, Drag
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_models
from hairpipe.strands.lattice import unbent
from hairpipe.strands.material import Material

SEGMENTS, LENGTH = 16, 0.08
ARC = np.deg2rad(120.0)


def arc_of(angle: float) -> np.ndarray:
    """Points of an arc along z that turns by an angle, in equal chords, (n+1, 3) [m]."""
    headings = angle * (np.arange(SEGMENTS) + 0.5) / SEGMENTS
    headings -= headings[0]
    steps = np.stack([np.sin(headings), 0.0 * headings, np.cos(headings)], axis=1) * LENGTH / SEGMENTS
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def tangents_of(points: np.ndarray) -> np.ndarray:
    ways = np.diff(points, axis=-2)
    return ways / np.linalg.norm(ways, axis=-1, keepdims=True)


def turns_of(points: np.ndarray) -> np.ndarray:
    """Angles between successive segments [rad]."""
    along = tangents_of(points)
    return np.arccos(np.clip(np.sum(along[1:] * along[:-1], axis=1), -1.0, 1.0))


def rest_of(points: np.ndarray, model: str, curvature: float, seconds: float = 1.0) -> np.ndarray:
    """Points of a strand where it comes to rest in thick air, (n+1, 3) [m]."""
    groom = unbound(points[None], np.eye(3, 4)[None])
    hair = build_models(groom, Material(), model, curvature=curvature).in_precision("double")
    scene = Scene(gravity=0.0, air=Air(Drag(60.0)))
    state = start(hair, None, scene)
    np.testing.assert_allclose(strands_of(hair, state).points, points, atol=1e-6)
    for _ in range(round(seconds * 24)):
        state = advance_frame(hair, state, (None, None), (), 1 / 24, scene)
    return strands_of(hair, state).points.astype(float)


SHARES = [*((model, share) for model in ("rod", "network") for share in (0.0, 0.5, 1.0)), ("chain", 0.0)]


@pytest.mark.parametrize(("model", "curvature"), SHARES)
def test_an_arc_ends_at_its_share_of_the_curvature(model, curvature):
    """The root is clamped, so that nothing but the rest shape bends hair."""
    found = rest_of(arc_of(ARC), model, curvature)
    np.testing.assert_allclose(turns_of(found), curvature * turns_of(arc_of(ARC)), atol=np.deg2rad(0.2))


def test_a_chain_takes_bent_hair_only_where_it_is_straight_at_rest():
    with pytest.raises(BadInput, match="straight"):
        rest_of(arc_of(ARC), "chain", 0.5)


def test_a_helix_keeps_its_torsion_and_gets_a_share_of_its_curvature():
    """Curvature r / (r^2 + c^2) and torsion c / (r^2 + c^2) of the helix of radius r and pitch 2 pi c."""
    helix, c = wound(Helix(0.006, 0.03), 0.3, 600), 0.03 / (2.0 * np.pi)
    found = unbent(helix[None], np.array([[1.0, 0.0, 0.0]]), 0.5)[0]
    for points, share in ((helix, 1.0), (found, 0.5)):
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).mean()
        along = tangents_of(points)
        binormals = np.cross(along[:-1], along[1:])
        binormals /= np.linalg.norm(binormals, axis=1, keepdims=True)
        torsion = np.arccos(np.clip(np.sum(binormals[1:] * binormals[:-1], axis=1), -1.0, 1.0)) / length
        assert turns_of(points)[50:-50].mean() / length == pytest.approx(share * 0.006 / (0.006**2 + c**2), rel=0.02)
        assert torsion[50:-50].mean() == pytest.approx(c / (0.006**2 + c**2), rel=0.02)
