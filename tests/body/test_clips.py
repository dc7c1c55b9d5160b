"""The clips we ship are what the code beside them makes."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from hairpipe.body.bust import build_skeleton
from hairpipe.body.performer import place_at_zero
from hairpipe.formats.bvh import read_bvh
from hairpipe.graphs.assets.bvh_writing import write_bvh

ASSETS = Path(__file__).resolve().parents[2] / "graphs" / "assets"


@pytest.fixture(params=["shake", "dance"])
def name(request):
    return request.param


@pytest.fixture
def clip(name, monkeypatch):
    monkeypatch.syspath_prepend(ASSETS)  # where a script finds what lies beside it
    spec = importlib.util.spec_from_file_location(name, ASSETS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.make_clip()


def test_the_file_is_what_the_code_writes(name, clip, tmp_path):
    write_bvh(tmp_path / f"{name}.bvh", clip)
    kept, made = read_bvh(ASSETS / f"{name}.bvh"), read_bvh(tmp_path / f"{name}.bvh")
    assert (kept.names, kept.channels, kept.frame_time) == (made.names, made.channels, made.frame_time)
    np.testing.assert_allclose(kept.values, made.values, atol=2e-6)  # another libm may round the last digit


def test_its_joints_are_those_of_the_bust(clip):
    skeleton = build_skeleton()
    assert clip.names == skeleton.names
    np.testing.assert_allclose(place_at_zero(clip).positions[0], skeleton.rest[:, :3, 3], atol=1e-12)


def test_it_lasts_as_long_as_the_shots_that_use_it(name, clip):
    assert (len(clip.values) - 1) * clip.frame_time > {"shake": 59.5, "dance": 239.5}[name] / 24.0
