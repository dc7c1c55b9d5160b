"""A file of guides: a reader of its own deforms all strands as `interpolate_hair` does."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from scipy.spatial.transform import Rotation

from hairpipe.body.shapes import build_box
from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.lint import lint
from hairpipe.geometry.rotations import root_frames
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.nodes.export_usd import export_usd
from hairpipe.nodes.interpolate_hair import interpolate_hair
from hairpipe.values import Groom, Guidance, Mesh, Strands
from hairpipe.values.strand_arrays import offsets_of, take

READER = Path(__file__).resolve().parents[2] / "docs/howto/deform_guides.py"
FRAMES = (1001, 1002)
COUNTS = np.array([6, 9, 6, 7, 9, 6])
KEYS = np.array([4, 1, 2])
"""Strands that are guides, not in order."""


@pytest.fixture(scope="module")
def body() -> dict[int, Mesh]:
    """A box that turns and moves."""
    box = build_box((0.2, 0.1, 0.2), (0.0, 0.0, 0.0))
    turns = {frame: Rotation.from_rotvec([0.1 * n, 0.5 * n, 0.0]) for n, frame in enumerate(FRAMES)}
    still = np.zeros(box.points.shape)
    return {f: Mesh(turn.apply(box.points) + 0.1 * (f - 1001), box.triangles, still) for f, turn in turns.items()}


@pytest.fixture(scope="module")
def groom(body) -> Groom:
    """Six crooked strands of different numbers of points, a root of which is off the skin."""
    rng = np.random.default_rng(3)
    rest = body[1001]
    sites = (rng.integers(0, len(rest.triangles), 6).astype(np.int32), rng.dirichlet(np.ones(3), 6))
    frames = root_frames(rest.points, rest.triangles, *sites)
    offsets = offsets_of(COUNTS)
    roots = np.repeat(frames[:, :, 3], COUNTS, axis=0)
    points = roots + 0.01 * np.cumsum(rng.normal(size=(offsets[-1], 3)), axis=0)
    points[offsets[:-1][:5]] = frames[:5, :, 3]
    ids = np.array([10, 11, 12, 20, 21, 22], np.int32)
    return Groom(points, offsets, ids, *sites, frames, np.zeros((6, 2), np.float32))


@pytest.fixture(scope="module")
def guidance(groom) -> Guidance:
    """Guides at random; guides follow themselves."""
    rng = np.random.default_rng(4)
    ids = rng.permuted(np.tile(groom.ids[KEYS], (6, 1)), axis=1)
    weights = rng.dirichlet(np.ones(3), 6)
    ids[KEYS] = groom.ids[KEYS, None]
    weights[KEYS] = (1.0, 0.0, 0.0)
    rest = groom.points + 0.002 * rng.normal(size=groom.points.shape)
    roots = groom.offsets[:-1]
    rest[roots] = groom.points[roots]
    return Guidance(ids, weights.astype(np.float32), rest)


@pytest.fixture(scope="module")
def keys(groom) -> Groom:
    return take(groom, KEYS)


@pytest.fixture(scope="module")
def hair(keys, body) -> dict[int, Strands]:
    """Hair of the keys, bent at random."""
    rng = np.random.default_rng(5)
    found = {}
    for frame in FRAMES:
        site = root_frames(body[frame].points, body[frame].triangles, keys.root_triangles, keys.root_barycentrics)
        turn = site[:, :, :3] @ np.swapaxes(keys.root_frames[:, :, :3], 1, 2)
        arms = keys.points - np.repeat(keys.root_frames[:, :, 3], np.diff(keys.offsets), axis=0)
        own = np.repeat(np.arange(3), np.diff(keys.offsets))
        noise = 0.003 * rng.normal(size=arms.shape)
        noise[keys.offsets[:-1]] = 0.0
        points = site[own, :, 3] + np.einsum("pij,pj->pi", turn[own], arms) + noise
        found[frame] = Strands(points, np.zeros(points.shape, np.float32), keys.offsets, 8e-5)
    return found


@pytest.fixture(scope="module")
def file(hair, body, groom, keys, guidance, tmp_path_factory) -> Path:
    frames = (Frames(FRAMES, hair.__getitem__), Frames(FRAMES, body.__getitem__))
    folder = Workspace(tmp_path_factory.mktemp("guides"))
    return export_usd(*frames, groom, None, keys, None, guidance, Time(1001, 24.0), (), folder).path


def test_the_reader_deforms_as_the_node_does(file, hair, body, groom, keys, guidance, tmp_path):
    target = tmp_path / "all.usdc"
    done = subprocess.run([sys.executable, READER, file, target], capture_output=True, text=True, check=True)
    assert "6 strands from 3" in done.stdout
    followed = weigh_keys(keys, groom, 30.0, guidance)
    stage = Usd.Stage.Open(str(target))
    prim = UsdGeom.BasisCurves(stage.GetPrimAtPath("/shot/strands"))
    for frame in FRAMES:
        settings = (body[frame], None, None, None, Time(frame, 24.0), followed)
        true = interpolate_hair(hair[frame], keys, groom, guidance, *settings).points
        assert np.array(prim.GetPointsAttr().Get(frame)) == pytest.approx(true, abs=2e-6)
    assert prim.GetPrim().IsActive()


def test_the_file_has_all_strands_once_and_guides_at_every_frame(file, groom, keys):
    stage = Usd.Stage.Open(str(file))
    guides, strands = (UsdGeom.BasisCurves(stage.GetPrimAtPath(f"/shot/{name}")) for name in ("hair", "strands"))
    assert guides.GetPointsAttr().GetTimeSamples() == [*FRAMES]
    assert strands.GetPointsAttr().GetTimeSamples() == []
    assert list(guides.GetCurveVertexCountsAttr().Get()) == [*np.diff(keys.offsets)]
    assert list(strands.GetCurveVertexCountsAttr().Get()) == [*COUNTS]
    assert UsdGeom.PrimvarsAPI(strands).GetPrimvar("guideWeight").GetElementSize() == 3


def test_the_file_passes_the_lint(file):
    assert not [finding for finding in lint(file) if finding.severity == "error"]


def test_guidance_needs_keys_groom_and_body(hair, groom, keys, guidance, tmp_path):
    frames = Frames(FRAMES, hair.__getitem__)
    with pytest.raises(BadInput, match="guidance without"):
        export_usd(frames, None, groom, None, keys, None, guidance, Time(1001, 24.0), (), Workspace(tmp_path))
