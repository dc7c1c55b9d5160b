"""Hair that is combed into an arc and straighter at rest, without gravity: where it comes to rest."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Air, Drag, Share
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_models
from hairpipe.strands.lattice import unbent
from hairpipe.strands.material import Material
from hairpipe.values.painting import Varied

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


def rest_of(points: np.ndarray, model: str, shape: float | Varied, seconds: float = 1.0) -> np.ndarray:
    """Points of a strand where it comes to rest in thick air, (n+1, 3) [m]."""
    groom = unbound(points[None], np.eye(3, 4)[None])
    hair = build_models(groom, Material(), model, shape=shape).in_precision("double")
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
    found = unbent(helix[None], np.array([[1.0, 0.0, 0.0]]), np.full((1, 601), 0.5))[0]
    for points, share in ((helix, 1.0), (found, 0.5)):
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).mean()
        along = tangents_of(points)
        binormals = np.cross(along[:-1], along[1:])
        binormals /= np.linalg.norm(binormals, axis=1, keepdims=True)
        torsion = np.arccos(np.clip(np.sum(binormals[1:] * binormals[:-1], axis=1), -1.0, 1.0)) / length
        assert turns_of(points)[50:-50].mean() / length == pytest.approx(share * 0.006 / (0.006**2 + c**2), rel=0.02)
        assert torsion[50:-50].mean() == pytest.approx(c / (0.006**2 + c**2), rel=0.02)


def natural_of(points: np.ndarray, shape: float | Varied) -> np.ndarray:
    """Return the natural curvatures k1, k2 and twist of a rod at its inner points, (n-1, 3)."""
    groom = unbound(points[None], np.eye(3, 4)[None])
    hair = build_models(groom, Material(), "rod", shape=shape).in_precision("double")
    return hair.layout.axis(hair.model.inverse_lengths[:, 1:4])[1:-1]


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_natural_curvature_of_a_rod_is_linear_in_its_shape(share):
    """A vertex that turns by an angle has 2 tan of half of it, so the share of an arc's is known in closed form."""
    found = natural_of(arc_of(ARC), Share(share))
    whole = natural_of(arc_of(ARC), 1.0)
    angle = ARC / SEGMENTS
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 2.0 * np.tan(share * angle / 2.0), atol=1e-12)
    np.testing.assert_allclose(found, share * whole, atol=3e-3 * np.abs(whole).max())


def test_natural_curvature_of_a_helix_is_scaled_and_its_twist_stays_zero():
    helix = wound(Helix(0.006, 0.03), 0.3, 300)
    whole = natural_of(helix, 1.0)
    np.testing.assert_allclose(natural_of(helix, 0.5), 0.5 * whole, atol=0.01 * np.abs(whole).max())
    np.testing.assert_array_equal(whole[:, 2], 0.0)


def test_a_strand_is_straight_at_rest_where_its_profile_is_zero():
    found = rest_of(arc_of(ARC), "rod", Share(1.0, profile=((0.49, 0.0), (0.51, 1.0))))
    turns = turns_of(found)
    half = SEGMENTS // 2
    np.testing.assert_allclose(turns[: half - 1], 0.0, atol=np.deg2rad(0.2))
    np.testing.assert_allclose(turns[half:], turns_of(arc_of(ARC))[half:], atol=np.deg2rad(0.2))


@pytest.mark.parametrize("model", ["rod", "network"])
def test_groups_of_other_shapes_leave_a_group_unchanged(model):
    pair = np.stack([arc_of(ARC), arc_of(ARC) + np.array([0.0, 0.01, 0.0])])
    groom = replace(unbound(pair, np.tile(np.eye(3, 4), (2, 1, 1))), groups=np.array([0, 1], np.int32))
    groom = replace(groom, group_names=("wavy", "ironed"))
    mixed = build_models(groom, Material(), model, shape=Share(1.0, groups=(("ironed", 0.0),))).in_precision("double")
    for shape, strand in ((1.0, 0), (0.0, 1)):
        alone = build_models(groom, Material(), model, shape=shape).in_precision("double")
        lane = alone.layout.strands[0].tolist().index(strand)
        for found, whole in zip(mixed.model, alone.model, strict=True):
            if np.ndim(found) > 1:
                np.testing.assert_array_equal(found[..., lane], whole[..., lane])
