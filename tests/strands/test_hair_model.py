"""What a groom must have to be simulated, and what is said of it."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.groom.strands import unbound
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import choose_precision
from hairpipe.strands.hair_model import build_hair, build_models
from hairpipe.strands.material import Material


@pytest.fixture
def groom(scene, straight):
    """Give grooms of strands of so many segments of some lengths [m]."""

    def of(*segments):
        whole = scene([straight(0.1, 10, [1.0, 0.2, 0.0]) for _ in segments]).hair.groom
        strands = whole.points.reshape(len(segments), 11, 3)
        scales = np.array(segments)[:, None, None] / 0.01
        return replace(whole, points=(strands[:, :1] + scales * (strands - strands[:, :1])).reshape(-1, 3))

    return of


def test_less_softened_short_strands_are_named_and_others_are_unchanged(groom):
    material = Material()
    with pytest.warns(UserWarning, match=r"softening = 100: 1 of 2 strands .* by 81.2 or more: strands 1$"):
        models = build_models(groom(0.01, 0.00057), material, "network")
        hair = choose_precision("double", models, Scene(), bodies=True, first=True)
    alone = build_hair(groom(0.01), material, "network")
    assert np.array_equal(hair.model.constants[:, :, 0], alone.model.constants[:, :, 0])
    assert hair.model.constants[0, 0, 1] == pytest.approx(100.0 / 81.2 * material.axial, rel=1e-3)


def test_segments_shorter_than_hair_is_thick_are_refused_by_name(groom):
    with pytest.raises(BadInput, match=r"segments of 5e-05 m, hair of 8e-05 m: strands 1 \(segments longer"):
        build_hair(groom(0.01, 0.00005), Material(), "network")


@pytest.mark.parametrize(("segments", "coarse"), [(25, True), (66, True), (72, False)])
def test_curls_of_few_segments_a_turn_are_named_with_the_number_that_they_need(segments, coarse):
    """A turn of radius 4 and pitch 8 mm is 26.4 mm of hair, 12 segments a turn are 68 of 0.15 m; chords count."""
    curl = wound(Helix(0.004, 0.008), 0.15, segments)
    turns = np.ptp(curl[:, 2]) / 0.008
    curly = unbound(curl[None], np.eye(3, 4)[None])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        choose_precision("double", build_models(curly, Material(), "rod"), Scene(), bodies=True, first=True)
    if not coarse:
        assert not caught
        return
    (warning,) = caught
    found = re.search(r"1 of 1 .* too stiff: strands 0 \(segments = (\d+) of the groom\)", str(warning.message))
    assert found and int(found[1]) == np.ceil(12.0 * turns)


def test_curls_are_named_where_springs_hold_them(groom):
    """A straight strand, one that bends by less than a turn, a curl, and a straight one that is rough."""
    whole, at = groom(*[0.01] * 4), np.arange(11)[:, None]
    strands = whole.points.reshape(4, 11, 3).copy()
    turn = np.linspace(0.0, 3.0, 11)
    strands[1, :, :2] = strands[1, 0, :2] + 0.03 * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)])
    strands[2] = strands[2, 0] + wound(Helix(0.004, 0.02), 0.1, 10) - wound(Helix(0.004, 0.02), 0.1, 10)[0]
    strands[3] += 1e-4 * np.random.default_rng(1).normal(size=(11, 3)) * (at > 0)
    curly = replace(whole, points=strands.reshape(-1, 3))
    with pytest.warns(
        UserWarning, match=r"1 of 4 strands are curls: strands 2; .* error of up to 10 %, or they do not come to rest"
    ):
        choose_precision("double", build_models(curly, Material(), "network"), Scene(), bodies=True, first=True)
    with pytest.warns(UserWarning, match=r"1 of 4 strands are curls of 2.9 segments a turn .*: strands 2 "):
        choose_precision("double", build_models(curly, Material(), "rod"), Scene(), bodies=True, first=True)
