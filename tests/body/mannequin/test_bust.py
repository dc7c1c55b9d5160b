"""The bust: one closed surface of human proportions, with weights, maps and texture coordinates."""

import numpy as np
import pytest

from hairpipe.body.anatomy import BUST
from hairpipe.body.blended_shapes import evaluate
from hairpipe.body.bust import EARS, build_bust, relax
from hairpipe.geometry.isosurface import extract_surface
from hairpipe.values.triangles import vertex_normals


@pytest.fixture(scope="module")
def bust():
    return build_bust()


@pytest.fixture
def facts(bust, measure_mesh):
    return measure_mesh(bust.mesh.points, bust.mesh.triangles)


def test_it_is_one_closed_surface_without_holes(bust, facts):
    assert facts["closed"] and facts["euler"] == 2
    assert 8_000 <= len(bust.mesh.triangles) <= 20_000


def test_no_triangle_is_degenerate(facts):
    assert facts["areas"].min() > 1e-6
    assert facts["shape"].min() > 0.2
    assert np.percentile(facts["shape"], 1.0) > 0.5


def test_volume_is_that_of_the_field(bust, facts):
    step = 0.004
    low, high = bust.mesh.points.min(axis=0), bust.mesh.points.max(axis=0)
    axes = [np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True)]
    samples = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = np.count_nonzero(evaluate(BUST, samples) < 0.0)
    assert facts["volume"] == pytest.approx(inside * step**3, rel=0.005)


def test_vertices_lie_on_the_field_and_triangles_face_out_of_it(bust):
    points = bust.mesh.points
    assert np.abs(evaluate(BUST, points)).max() < 2e-4
    outward = vertex_normals(bust.mesh)
    assert (evaluate(BUST, points + 0.001 * outward) > 0.0).mean() > 0.999


def test_proportions_are_human(bust):
    points = bust.mesh.points
    assert points[:, 1].max() == pytest.approx(0.450, abs=0.003)  # crown; the chin is at 0.22
    skull = points[points[:, 1] > 0.37]  # above the ears
    assert np.ptp(skull[:, 0]) == pytest.approx(0.155, abs=0.004)
    assert np.ptp(skull[:, 2]) == pytest.approx(0.195, abs=0.006)
    assert np.ptp(points[:, 0]) == pytest.approx(0.40, abs=0.01)
    chin = points[(points[:, 2] > 0.07) & (points[:, 1] > 0.20)]
    assert chin[:, 1].min() == pytest.approx(0.225, abs=0.006)


def test_left_mirrors_right(bust):
    front = bust.mesh.points * (-1.0, 1.0, 1.0)
    assert np.abs(evaluate(BUST, front)).max() < 2e-4


def test_it_is_the_same_every_time(bust):
    again = build_bust()
    assert again.mesh.points.tobytes() == bust.mesh.points.tobytes()
    assert again.weights.tobytes() == bust.weights.tobytes()


def test_weights_are_a_smooth_partition(bust):
    assert (bust.weights >= 0.0).all()
    np.testing.assert_allclose(bust.weights.sum(axis=1), 1.0, atol=1e-12)
    a, b = bust.mesh.triangles[:, 0], bust.mesh.triangles[:, 1]
    jump = np.abs(bust.weights[a] - bust.weights[b]).max(axis=1)
    length = np.linalg.norm(bust.mesh.points[a] - bust.mesh.points[b], axis=1)
    assert (jump / length).max() < 40.0  # [1/m]: no crease where the neck bends


def weight_of(bust, name: str, where: np.ndarray) -> np.ndarray:
    return bust.weights[where, bust.skeleton.names.index(name)]


def test_jaw_and_skull_follow_the_head_and_shoulders_the_chest(bust):
    x, y, z = bust.mesh.points.T
    assert weight_of(bust, "head", (y > 0.30) | ((z > 0.05) & (y > 0.23))).min() > 0.9
    assert weight_of(bust, "chest", (np.abs(x) > 0.12) | (y < 0.08)).min() > 0.95


def value_at(bust, name: str, place: tuple[float, float, float]) -> float:
    nearest = np.argmin(np.linalg.norm(bust.mesh.points - place, axis=1))
    return bust.maps[name][nearest]


@pytest.mark.parametrize(
    ("place", "scalp"),
    [
        ((0.0, 0.45, -0.02), 1.0),  # crown
        ((0.0, 0.36, -0.105), 1.0),  # back of the head
        ((0.075, 0.39, -0.01), 1.0),  # above the ear
        ((0.0, 0.30, 0.11), 0.0),  # nose
        ((0.0, 0.37, 0.09), 0.0),  # forehead
        ((0.085, 0.33, -0.02), 0.0),  # ear
        ((0.0, 0.20, -0.09), 0.0),  # neck
        ((0.15, 0.14, -0.03), 0.0),  # shoulder
    ],
)
def test_hair_grows_on_the_scalp_alone(bust, place, scalp):
    assert value_at(bust, "scalp", place) == pytest.approx(scalp, abs=1e-6)


def test_hair_is_longest_at_the_crown(bust):
    assert value_at(bust, "length", (0.0, 0.45, -0.02)) == pytest.approx(1.0)
    assert value_at(bust, "length", (0.0, 0.28, -0.08)) < 0.7
    assert all(values.min() >= 0.0 and values.max() <= 1.0 for values in bust.maps.values())


def test_no_texel_lies_in_two_triangles(bust):
    uv, size = bust.mesh.uv.astype(float), 1024
    count = np.zeros((size, size), int)
    for (ax, ay), (bx, by), (cx, cy) in uv * size - 0.5:
        across = np.arange(np.ceil(min(ax, bx, cx)), max(ax, bx, cx))
        up = np.arange(np.ceil(min(ay, by, cy)), max(ay, by, cy))
        x, y = np.meshgrid(across, up, indexing="ij")
        sides = [(bx - ax, by - ay, ax, ay), (cx - bx, cy - by, bx, by), (ax - cx, ay - cy, cx, cy)]
        inside = np.all([dx * (y - oy) - dy * (x - ox) > 1e-9 for dx, dy, ox, oy in sides], axis=0)
        np.add.at(count, (x[inside].astype(int), y[inside].astype(int)), 1)
    assert count.max() == 1 and count.mean() > 0.45
    areas = np.cross(uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0])
    assert (areas > 0.0).all() and uv.min() >= 0.0 and uv.max() <= 1.0


def test_texels_of_the_scalp_are_of_even_size(bust):
    """Between half of and twice the median, so that a painted map is equally sharp everywhere."""
    points, triangles = bust.mesh.points, bust.mesh.triangles
    on_scalp = (bust.maps["scalp"][triangles] > 0.5).all(axis=1)
    corners, uv = points[triangles[on_scalp]], bust.mesh.uv[on_scalp].astype(float)
    skin = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    sizes = np.sqrt(skin / np.cross(uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0])) / 512
    assert 0.0005 < 0.5 * np.median(sizes) < sizes.min() and sizes.max() < 2.0 * np.median(sizes) < 0.004


def test_ears_are_where_the_hairline_is_drawn_from(bust):
    ears = bust.mesh.points[np.abs(bust.mesh.points[:, 0]) > 0.081]
    ears = ears[ears[:, 1] > 0.25]
    assert np.linalg.norm(ears.mean(axis=0)[1:] - np.array(EARS)[1:]) < 0.02


AXES = (np.linspace(-1.2, 1.2, 25),) * 3


def rough_ball() -> tuple[np.ndarray, np.ndarray]:
    x, y, z = np.meshgrid(*AXES, indexing="ij")
    return extract_surface(np.sqrt(x * x + y * y + z * z) - 0.9, AXES)


def onto_ball(points: np.ndarray) -> np.ndarray:
    return 0.9 * points / np.linalg.norm(points, axis=1, keepdims=True)


def test_relaxing_keeps_the_surface_and_evens_the_triangles(measure_mesh):
    points, triangles = rough_ball()
    before = onto_ball(points)
    after = relax(before, triangles, onto_ball, rounds=8)
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), 0.9, rtol=1e-12)
    worst = [np.percentile(measure_mesh(p, triangles)["shape"], 1.0) for p in (before, after)]
    assert worst[1] > worst[0]
    assert measure_mesh(after, triangles)["volume"] > 0.99 * measure_mesh(before, triangles)["volume"]
