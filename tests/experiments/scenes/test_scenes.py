"""Scenes that are drawn at random are graphs, all kinds of them, and the same every time."""

import re
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from hairpipe.app.api.shot import load
from hairpipe.graphs.experiments.scenes import drawing

GRAPHS = Path(__file__).resolve().parents[3] / "graphs"


@pytest.mark.parametrize("seed", range(4))
def test_they_can_be_loaded_and_the_hair_is_the_same_in_both_motions(seed):
    for number in range(1, 4):
        scene = drawing.draw_scene(seed, number)
        _, tables = scene.other
        one, other = (load(given, folder=GRAPHS) for given in (scene.tables, tables))
        assert one.nodes[drawing.HAIR].type.name == "simulate_hair"
        assert [(n.name, n.type.name) for n in one.nodes.values()] == [
            (n.name, n.type.name) for n in other.nodes.values()
        ]
        assert all(scene.tables[name] == tables[name] for name in ("groom", drawing.HAIR, "frames"))
        assert scene.tables["body"] != tables["body"] or scene.tables["motion"] != tables["motion"]


def test_a_scene_depends_on_seed_and_number_alone():
    assert drawing.draw_scene(1, 2) == drawing.draw_scene(1, 2)
    drawn = [drawing.draw_scene(seed, number).tables for seed in (1, 2) for number in (1, 2)]
    assert not any(drawn[one] == drawn[other] for one in range(4) for other in range(one))


def test_all_kinds_have_their_frequency():
    scenes = [drawing.draw_scene(5, number) for number in range(400)]
    between = Counter(
        tuple(g for g in ("stiction", "collisions", "volume") if g in s.tables[drawing.HAIR]) for s in scenes
    )
    assert between.keys() == set(drawing.BETWEEN)
    assert {scene.tolerance.value for scene in scenes} == set(drawing.TOLERANCES)
    curled = [scene.tables["groom"] for scene in scenes if "curl" in scene.tables["groom"]]
    assert len(curled) == pytest.approx(400 * drawing.CURLS, abs=4 * (400 * drawing.CURLS * (1 - drawing.CURLS)) ** 0.5)
    motions = Counter(re.sub(r"[\d.]+", "#", scene.other[0]) for scene in scenes)
    assert len(motions) == 5 and min(motions.values()) > 50


def test_a_curl_has_as_many_turns_as_its_segments_can_show():
    """Along a helix of radius r and pitch h a turn is as long as the diagonal of 2 pi r and h."""
    grooms = [drawing.draw_scene(7, number).tables["groom"] for number in range(200)]
    for groom in (groom for groom in grooms if "curl" in groom):
        curl = groom["curl"]
        turn = ((6.28319 * curl["radius"]["value"]) ** 2 + curl["pitch"]["value"] ** 2) ** 0.5
        assert drawing.TURNS[0] * 0.98 <= groom["length"]["value"] / turn <= drawing.TURNS[1] * 1.02
    assert drawing.SEGMENTS / drawing.TURNS[1] >= 8


def test_keys_ascend_and_lie_in_the_shot():
    tracks = [
        s.tables["body"]["motion"]
        for s in (drawing.draw_scene(9, n) for n in range(60))
        if "motion" in s.tables["body"]
    ]
    assert len(tracks) > 20
    for track in tracks:
        times = track["times"]
        assert len(times) >= 3 and times[0] == 0.0 and times[-1] < (drawing.FRAMES[1] - drawing.FRAMES[0]) / drawing.FPS
        assert all(0.24 < after - before < 0.51 for before, after in pairwise(times))
