"""Connections that are absent are named at the first frame; settings that contradict each other are refused."""

import warnings
from dataclasses import replace

import pytest

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import BodyContact, Wind
from hairpipe.levelset.bake import bake
from hairpipe.shot.shot import Frame, next_state
from hairpipe.shot.simulate import StrandSimulation
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material


@pytest.fixture
def shot(scene, straight):
    return scene([straight(0.1, 10, [1.0, 0.2, 0.0]) for _ in range(3)])


@pytest.fixture
def block(box):
    return bake(box((-0.2, -0.2, -0.2), (0.2, -0.05, 0.2)), 0.01, 3.0)


def frame_of(driver, *surfaces):
    return Frame((driver, driver), [(surface, surface) for surface in surfaces], (), 0.0, 1 / 24)


def begin(shot, frame, **scene):
    next_state(StrandSimulation(shot.hair, replace(shot.scene, **scene)), None, frame)


def test_a_body_without_level_set_and_a_level_set_without_body_are_named(shot, block):
    with pytest.warns(UserWarning, match=r"^in.body without in.surface and in.parts: .* \(in.surface = a bake_lev"):
        begin(shot, frame_of(shot.body))
    with pytest.warns(UserWarning, match=r"^bodies without in.body: roots stay at rest, .* \(in.body = the body that"):
        begin(shot, frame_of(None, block))


def test_settings_of_contact_without_a_body_to_touch_are_named(shot):
    with pytest.warns(UserWarning, match=r"^contact without in.surface and in.parts: hair passes through bodies"):
        begin(shot, frame_of(None), contact=BodyContact(friction=0.5))


def test_wind_above_any_storm_is_named(shot, block):
    with pytest.warns(UserWarning, match=r"^wind.velocity has 1,000 m/s, above 115 m/s, .*\(velocities are in m/s\)"):
        begin(shot, frame_of(shot.body, block), wind=Wind(velocity=(0.0, 0.0, -1000.0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        begin(shot, frame_of(shot.body, block), wind=Wind(velocity=(0.0, 30.0, -100.0)))


def test_whole_scenes_and_hair_alone_are_not_warned_of(shot, block):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        begin(shot, frame_of(shot.body, block))
        begin(shot, frame_of(None))
        shot.hair = build_hair(lay_strands(2, 0.1, 10, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0), Material(), "rod")
        begin(shot, frame_of(None, block))  # on no body: its roots rest


GRAPH = """schema = 1
frames = [1, 2]
fps = 24
[tuft]
type = "make_strands"
[hair]
type = "simulate_hair"
in.groom = "tuft"
"""


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "stiction = { reach = 2e-3, release = 1e-3 }",
            r"hair.*stiction: the release distance, 0.001 m, is not more than the reach, 0.002 m \(a larger release",
        ),
        (
            "rest = { shape = 0.5, balanced = 1.0 }",
            r"\[hair\].* shape below 1 contradicts balanced, .*\(balanced = 0, or",
        ),
        ("rest.shape = 1.5", r"rest.shape.value = 1.5 is not allowed"),
        ("rest.balanced = { value = 1.0, profile = [[0.0, 1.0]] }", r"balanced varies along strands"),
        ("sag_free = {}", r"unknown setting 'sag_free' \(rest.balanced = 1.0, and its settings"),
        ("curvature = 0.5", r"unknown setting 'curvature' \(its value as rest.shape\)"),
    ],
)
def test_contradictions_are_refused(line, message):
    with pytest.raises(BadInput, match=message):
        hairpipe.load(GRAPH + line + "\n")
    assert hairpipe.load(GRAPH + "rest.shape = 0.5\nstiction = { reach = 2e-3, release = 3e-3 }\n")
