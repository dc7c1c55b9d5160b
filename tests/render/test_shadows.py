"""Shadows against the number of hairs a ray crosses, sums over every strand, and what stands in the light."""

import numpy as np
import pytest

from hairpipe.render.deep_shadow import (
    OPACITY,
    TEXELS,
    TOLERANCE,
    DeepShadow,
    cast_deep_shadow,
    compress,
    transmittance,
)
from hairpipe.render.lights import Light
from hairpipe.render.shadows import SOLID, Shadow, apply, cast_shadow, look_up
from hairpipe.values import Mesh

NOBODY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
TOWARDS = np.array([[0.0, 1.0, 0.0], [0.48, 0.6, 0.64], [1.0, 0.0, 0.0]])


def between(shadow: Shadow, points: np.ndarray) -> np.ndarray:
    """Optical depth at every point."""
    return np.array([look_up(shadow.depth, shadow.to_cells, *point) for point in points])


@pytest.mark.parametrize("brightness", [1.0, 0.5])
@pytest.mark.parametrize("towards", TOWARDS)
def test_depth_behind_a_sheet_of_hair_is_its_coverage(towards: np.ndarray, brightness: float) -> None:
    side = np.cross(towards, [0.3, -0.5, 0.8])
    side /= np.linalg.norm(side)
    along, count, width = np.cross(towards, side), 400, 2e-3
    rows = np.linspace(-0.4, 0.4, count)[:, None, None] * side
    sheet = rows + np.linspace(-0.4, 0.4, 60)[None, :, None] * along
    offsets = np.arange(0, 60 * count + 1, 60)
    light = Light(towards, np.full(3, brightness))
    shadow = cast_shadow(light, np.zeros(3), 0.5, sheet.reshape(-1, 3), offsets, width, NOBODY)
    coverage = count * width / 0.8
    assert between(shadow, np.array([-0.2, -0.05])[:, None] * towards) == pytest.approx(coverage, rel=0.02)
    assert between(shadow, np.array([0.05, 0.3])[:, None] * towards) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("cast", "closely"), [(cast_shadow, 0.05), (cast_deep_shadow, 0.1)])
def test_strands_that_vary_cast_the_shadow_of_their_area(cast, closely: float) -> None:
    """One half of the hair is twice as thick as the other: each casts the shadow of its area."""
    count, width = 400, 2e-3
    x, z = np.linspace(-0.4, 0.4, count), np.linspace(-0.4, 0.4, 60)
    sheet = np.stack([np.repeat(x, 60), np.zeros(60 * count), np.tile(z, count)], axis=1)
    widths = np.where(sheet[:, 0] < 0.0, 2.0, 1.0) * width * np.tile(np.linspace(1.0, 0.0, 60), count)
    offsets = np.arange(0, 60 * count + 1, 60)
    shadow = cast(Light(TOWARDS[0], np.ones(3)), np.zeros(3), 0.5, sheet, offsets, widths, NOBODY)
    below = np.array([[x, -0.2, 0.0] for x in (-0.2, 0.2)]), np.array([[0.2, -0.2, z] for z in (-0.2, 0.2)])
    found = [shadow.between(places) for places in below]
    coverage = count * width / 0.8
    np.testing.assert_allclose(found[0], [coverage, 0.5 * coverage], atol=closely)
    np.testing.assert_allclose(found[1], [0.75 * coverage, 0.25 * coverage], atol=closely)


def test_hair_along_the_light_casts_none() -> None:
    strand = np.linspace(0.3, -0.3, 20)[:, None] * TOWARDS[0]
    light = Light(TOWARDS[0], np.ones(3))
    shadow = cast_shadow(light, np.zeros(3), 0.5, strand, np.array([0, 20]), 0.01, NOBODY)
    assert shadow.depth.max() < 1e-6


LAMPS = [Light(np.array(towards), np.ones(3)) for towards in ([0.0, 1.0, 0.0], [0.48, 0.6, 0.64])]
CENTRE = np.array([0.0, 1.6, 0.0])


def through(shadow: Shadow | DeepShadow, points: np.ndarray) -> np.ndarray:
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


@pytest.mark.parametrize(("cast", "near", "off"), [(cast_shadow, 0.01, 1e-9), (cast_deep_shadow, 0.005, TOLERANCE)])
@pytest.mark.parametrize("towards", TOWARDS)
def test_the_body_hides_what_is_behind_it_and_not_its_lit_side(towards, head: Mesh, cast, near: float, off: float):
    none = np.zeros((0, 3)), np.zeros(1, np.int32)
    shadow = cast(Light(towards, np.ones(3)), CENTRE, 0.3, *none, 1e-3, head)
    aside = np.cross(towards, [0.3, -0.5, 0.8])
    aside /= np.linalg.norm(aside)
    hidden = [CENTRE - 0.1 * towards, CENTRE - 0.25 * towards, CENTRE - 0.2 * towards + (0.09 - near) * aside]
    lit = [CENTRE + 0.09 * towards, CENTRE + 0.2 * towards, CENTRE - 0.2 * towards + (0.09 + near) * aside]
    assert through(shadow, np.array(hidden)) == pytest.approx(np.exp(-OPACITY * SOLID), abs=off)
    assert through(shadow, np.array(lit)) == pytest.approx(1.0, abs=off)


def test_the_edge_of_the_body_is_finer_than_the_cells_of_a_cube(head: Mesh) -> None:
    light, none = LAMPS[1], (np.zeros((0, 3)), np.zeros(1, np.int32), 1e-3)
    aside = np.cross(light.towards, [0.3, -0.5, 0.8])
    aside /= np.linalg.norm(aside)
    line = CENTRE - 0.2 * light.towards + np.linspace(0.07, 0.11, 401)[:, None] * aside

    def blur(depths: np.ndarray) -> int:
        return int(np.sum((depths > 0.05 * SOLID) & (depths < 0.95 * SOLID)))

    deep, cube = (cast(light, CENTRE, 0.3, *none, head).between(line) for cast in (cast_deep_shadow, cast_shadow))
    assert 0 < 2 * blur(deep) < blur(cube)


def test_a_map_has_the_same_bytes_on_any_number_of_threads(head: Mesh, same_on_threads) -> None:
    same_on_threads(lambda: cast_deep_shadow(LAMPS[1], CENTRE, 0.1, *strands(300), 8e-5, head))


def test_far_strands_cast_no_shadow() -> None:
    strand = np.array([[0.0, 1.6, 0.0], [3e38, -3e38, 1e30], [0.0, 3e38, 0.0]])
    shadow = cast_deep_shadow(LAMPS[0], CENTRE, 0.1, strand, np.array([0, 3]), 8e-5, NOBODY)
    assert through(shadow, CENTRE + np.array([[0.0, -0.05, 0.01], [0.02, 0.05, 0.0]])) == pytest.approx(1.0, abs=0.02)


def fragments_of(count: int, most: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random ones, some of them at one depth, as a map holds them."""
    rng = np.random.default_rng(seed)
    depths = np.sort(np.round(rng.uniform(0.0, 40.0, count), rng.integers(0, 4)))
    return depths.astype(np.float32), rng.uniform(0.0, most, count).astype(np.float32)


def compressed(depths: np.ndarray, opacities: np.ndarray, tolerance: float) -> np.ndarray:
    """Knots, (k, 2)."""
    knots = np.full((2 * len(depths), 2), np.nan, np.float32)
    return knots[: compress(depths, opacities, tolerance, knots)]


@pytest.mark.parametrize("tolerance", [0.0, 0.005, 0.02, 0.1])
@pytest.mark.parametrize("most", [0.02, 0.3, 1.0])
def test_it_is_nowhere_farther_than_the_tolerance_from_the_product(most: float, tolerance: float) -> None:
    for seed in range(40):
        depths, opacities = fragments_of(1 + 4 * seed, most, seed)
        knots = compressed(depths, opacities, tolerance)
        between = np.linspace(-1.0, 42.0, 300)
        places = np.concatenate([between, depths, depths + np.float32(1e-3), depths - np.float32(1e-3)])
        read = [transmittance(knots, 0, len(knots), place) for place in places]
        brute = [np.prod(1.0 - opacities[depths <= place].astype(float)) for place in places]
        assert np.abs(np.array(read) - brute).max() <= tolerance + 1e-6


@pytest.mark.parametrize("most", [0.02, 0.3, 1.0])
def test_it_never_rises_and_knots_follow_one_another(most: float) -> None:
    for seed in range(40):
        knots = compressed(*fragments_of(1 + 4 * seed, most, seed), 0.02)
        assert np.isfinite(knots).all() and (np.diff(knots[:, 0]) >= 0.0).all() and (np.diff(knots[:, 1]) <= 1e-6).all()
        assert knots[0, 1] == 1.0


def test_light_that_dies_away_evenly_needs_few_knots() -> None:
    depths, opacities = np.arange(400, dtype=np.float32), np.full(400, 0.01, np.float32)
    knots = compressed(depths, opacities, 0.02)
    assert len(knots) < 10  # of chords of exp(-x) that miss it by 0.02 either way, five reach down to 0.02


def test_all_light_arrives_where_nothing_is() -> None:
    assert transmittance(np.empty((0, 2), np.float32), 0, 0, 3.0) == 1.0
