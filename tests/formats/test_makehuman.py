import json

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.makehuman import read_skeleton, read_weights

POINTS = np.array([[0.0, 0, 0], [2.0, 0, 0], [0, 4.0, 0], [0, 0, 6.0]])
RIG = {
    "bones": {"tip": {"head": "b", "tail": "c", "parent": "base"}, "base": {"head": "a", "tail": "b", "parent": None}},
    "joints": {"a": [0], "b": [0, 1], "c": [2, 3]},
}
WEIGHTS = {"weights": {"base": [[0, 1.0], [1, 0.25], [2, 0.1]], "tip": [[1, 0.5], [2, 0.1], [2, 0.2]]}}
NAMES = ("base", "tip")


def written(folder, content):
    path = folder / "file.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_joints_stand_at_the_mean_of_their_vertices_parents_first(tmp_path):
    skeleton = read_skeleton(written(tmp_path, RIG), POINTS)
    assert skeleton.names == NAMES
    np.testing.assert_array_equal(skeleton.parents, [-1, 0])
    np.testing.assert_array_equal(skeleton.rest[:, :3, 3], [[0, 0, 0], [1, 0, 0]])
    np.testing.assert_array_equal(skeleton.rest[:, :3, :3], np.tile(np.eye(3), (2, 1, 1)))
    np.testing.assert_array_equal(skeleton.tips, [[1, 0, 0], [0, 2, 3]])


def test_weights_are_normalised_heaviest_first_and_the_rest_follow_the_root(tmp_path):
    joints, weights = read_weights(written(tmp_path, WEIGHTS), NAMES, 4)
    np.testing.assert_array_equal(joints, [[0, 1], [1, 0], [1, 0], [0, 1]])
    np.testing.assert_allclose(weights, [[1, 0], [2 / 3, 1 / 3], [0.75, 0.25], [1, 0]])


def changed(content: dict, path: str, value) -> dict:
    copy = json.loads(json.dumps(content))
    *folders, last = path.split(".")
    place = copy
    for name in folders:
        place = place[name]
    place[last] = value
    return copy


TAIL, OUT = r"bones\.tip\.tail", "out of range"
BROKEN: list[tuple[str, object, str]] = [
    ("bones", [], "'bones' is missing"),
    ("bones", {}, "'bones' is missing, empty"),
    ("joints", None, "'joints' is missing"),
    ("bones.tip", 3, "parent '' does not exist"),
    ("bones.tip.parent", "nobody", r"bones\.tip: parent 'nobody' does not exist"),
    ("bones.tip.parent", "tip", r"bones\.tip: the bone is its own ancestor"),
    ("bones.base.parent", "tip", "its own ancestor"),
    ("bones.tip.head", "nowhere", r"bones\.tip\.head"),
    *(("bones.tip.tail", value, TAIL) for value in (["a"], {}, 3)),
    *(("joints.c", value, TAIL) for value in ([], [4], [-1], [1.5], [True])),
    ("weights", None, "'weights' is missing"),
    ("weights.wing", [[0, 1.0]], "no bone 'wing'"),
    ("weights.tip", {}, "does not consist of pairs"),
    ("weights.tip", [[0]], "does not consist of pairs"),
    ("weights.tip", [[4, 0.5]], r"weights\.tip: .*out of range .*0 to 3"),
    *(("weights.tip", [[vertex, 0.5]], OUT) for vertex in (-1, "0")),
    *(("weights.tip", [[0, weight]], OUT) for weight in (-0.5, float("nan"), float("inf"), None)),
]


@pytest.mark.parametrize(("path", "value", "message"), BROKEN)
def test_broken_rigs_and_weights_are_refused(tmp_path, path, value, message):
    with pytest.raises(BadInput, match=message):
        if path.startswith("weights"):
            read_weights(written(tmp_path, changed(WEIGHTS, path, value)), NAMES, 4)
        else:
            read_skeleton(written(tmp_path, changed(RIG, path, value)), POINTS)


INVALID = {
    '{"bones": ': "line 1",
    "[1]": "not an object",
    "[" * 100_000: "nested too deeply",
    "9" * 5000: "too long a n",
}


@pytest.mark.parametrize(("text", "message"), INVALID.items(), ids=INVALID.values())
def test_invalid_json_is_refused(tmp_path, text, message):
    with pytest.raises(BadInput, match=message):
        read_skeleton(written(tmp_path, text), POINTS)


def test_the_real_rig_fits_the_real_body(shared):
    from hairpipe.formats.obj import read_polygons

    folder = shared / "body_makehuman"
    points = read_polygons(folder / "base.obj").mesh.points
    skeleton = read_skeleton(folder / "default.mhskel", points)
    assert len(skeleton.names) == 163 and (skeleton.parents < np.arange(163)).all()
    head = skeleton.names.index("head")
    np.testing.assert_allclose(skeleton.rest[head, :3, 3], [0.0, 6.975, 0.161], atol=5e-4)
    np.testing.assert_allclose(skeleton.tips[head], [0.0, 8.404, 0.082], atol=5e-4)
    joints, weights = read_weights(folder / "default_weights.mhw", skeleton.names, len(points))
    assert (weights[:13380] > 0.0).sum(axis=1).max() == 9
    heavy = np.where(joints == head, weights, 0.0).sum(axis=1)[:13380]
    assert np.count_nonzero(heavy > 0.0) == 4240
    assert np.count_nonzero(heavy >= 0.5) == pytest.approx(2635, abs=25)  # counted before the rows were scaled
