"""Deep shadow maps against sums over every strand, against the body, and against the cube."""

import numba
import numpy as np
import pytest

from hairpipe.render.deep_shadow import OPACITY, TEXELS, TOLERANCE, DeepShadow, cast_deep_shadow
from hairpipe.render.lights import Light
from hairpipe.render.shadows import SOLID, apply, cast_shadow
from hairpipe.values import Mesh

NOBODY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
LAMPS = [Light(np.array(towards), np.ones(3)) for towards in ([0.0, 1.0, 0.0], [0.48, 0.6, 0.64])]
CENTRE = np.array([0.0, 1.6, 0.0])


def through(shadow: DeepShadow, points: np.ndarray) -> np.ndarray:
    """Transmittance to points."""
    return np.exp(-OPACITY * shadow.between(points))


def strands(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Random ones of 8 points in a ball of 2 cm: points and offsets."""
    rng = np.random.default_rng(3)
    points = CENTRE + 0.02 * rng.uniform(-1.0, 1.0, (count, 1, 3)) + np.cumsum(rng.normal(0, 2e-3, (count, 8, 3)), 1)
    return points.reshape(-1, 3), np.arange(0, 8 * count + 1, 8, dtype=np.int32)


def short_pieces(places: np.ndarray, offsets: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Middles of 40 pieces of every segment, (n, 3), and the area that they show the lamp, (n,) [texels]."""
    first = np.setdiff1d(np.arange(len(places)), offsets[1:] - 1)
    run = places[first + 1] - places[first]
    middles = places[first][:, None] + ((np.arange(40) + 0.5) / 40)[None, :, None] * run[:, None]
    return middles.reshape(-1, 3), np.repeat(width * np.linalg.norm(run[:, :2], axis=1) / 40, 40)


@pytest.mark.parametrize("light", LAMPS)
def test_light_along_a_ray_is_within_the_tolerance_of_a_sum_over_all_strands(light: Light) -> None:
    points, offsets = strands(2000)
    shadow = cast_deep_shadow(light, CENTRE, 0.1, points, offsets, 8e-5, NOBODY)
    middles, areas = short_pieces(apply(shadow.to_cells, points), offsets, 8e-5 / shadow.cell)
    rng, depths = np.random.default_rng(8), np.linspace(200.0, 310.0, 12)
    places, brute = [], []
    for texel in TEXELS // 2 + rng.integers(-40, 40, (16, 2)):
        part = rng.uniform(size=2) * rng.integers(0, 2)  # on a ray, or between four
        light_there = np.zeros(len(depths))
        for corner in np.ndindex(2, 2):
            tent = np.prod(np.maximum(0.0, 1.0 - np.abs(middles[:, :2] - 0.5 - texel - corner)), axis=1)
            near = np.flatnonzero(tent)
            shown, there = areas[near] * tent[near], middles[near, 2]
            hairs = [shown[there <= depth].sum() for depth in depths]
            light_there += np.prod(np.where(corner, part, 1.0 - part)) * np.exp(-OPACITY * np.array(hairs))
        brute.extend(light_there)
        places.extend([*(texel + 0.5 + part), depth] for depth in depths)
    read = through(shadow, np.linalg.solve(shadow.to_cells[:, :3], (places - shadow.to_cells[:, 3]).T).T)
    assert min(brute) < 0.7 and max(brute) > 0.98
    assert np.abs(read - brute).max() < TOLERANCE + 0.005  # pieces of a texel against short ones


@pytest.mark.parametrize("light", LAMPS)
def test_the_body_hides_what_is_behind_it_and_not_its_lit_side(light: Light, head: Mesh) -> None:
    shadow = cast_deep_shadow(light, CENTRE, 0.3, np.zeros((0, 3)), np.zeros(1, np.int32), 1e-3, head)
    towards, aside = light.towards, np.cross(light.towards, [0.3, -0.5, 0.8])
    aside /= np.linalg.norm(aside)
    hidden = [CENTRE - 0.1 * towards, CENTRE - 0.25 * towards, CENTRE - 0.2 * towards + 0.085 * aside]
    lit = [CENTRE + 0.09 * towards, CENTRE + 0.2 * towards, CENTRE - 0.2 * towards + 0.095 * aside]
    assert through(shadow, np.array(hidden)) == pytest.approx(np.exp(-OPACITY * SOLID), abs=TOLERANCE)
    assert through(shadow, np.array(lit)) == pytest.approx(1.0, abs=TOLERANCE)


def test_the_edge_of_the_body_is_finer_than_the_cells_of_a_cube(head: Mesh) -> None:
    light, none = LAMPS[1], (np.zeros((0, 3)), np.zeros(1, np.int32), 1e-3)
    aside = np.cross(light.towards, [0.3, -0.5, 0.8])
    aside /= np.linalg.norm(aside)
    line = CENTRE - 0.2 * light.towards + np.linspace(0.07, 0.11, 401)[:, None] * aside

    def blur(depths: np.ndarray) -> int:
        return int(np.sum((depths > 0.05 * SOLID) & (depths < 0.95 * SOLID)))

    deep, cube = (cast(light, CENTRE, 0.3, *none, head).between(line) for cast in (cast_deep_shadow, cast_shadow))
    assert 0 < 2 * blur(deep) < blur(cube)


def test_a_map_has_the_same_bytes_on_any_number_of_threads(head: Mesh) -> None:
    before = numba.get_num_threads()
    try:
        maps = []
        for threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
            numba.set_num_threads(threads)
            maps.append(cast_deep_shadow(LAMPS[1], CENTRE, 0.1, *strands(300), 8e-5, head))
    finally:
        numba.set_num_threads(before)
    assert maps[0].starts.tobytes() == maps[1].starts.tobytes() and maps[0].knots.tobytes() == maps[1].knots.tobytes()


def test_far_strands_cast_no_shadow() -> None:
    strand = np.array([[0.0, 1.6, 0.0], [3e38, -3e38, 1e30], [0.0, 3e38, 0.0]])
    shadow = cast_deep_shadow(LAMPS[0], CENTRE, 0.1, strand, np.array([0, 3]), 8e-5, NOBODY)
    assert through(shadow, CENTRE + np.array([[0.0, -0.05, 0.01], [0.02, 0.05, 0.0]])) == pytest.approx(1.0, abs=0.02)
