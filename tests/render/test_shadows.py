"""Shadows against the number of hairs a ray crosses, and against what stands in the light."""

import numpy as np
import pytest

from hairpipe.render.deep_shadow import cast_deep_shadow
from hairpipe.render.lights import Light
from hairpipe.render.shadows import SOLID, Shadow, cast_shadow, look_up
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


@pytest.mark.parametrize("towards", TOWARDS)
def test_the_body_hides_what_is_behind_it_and_not_its_lit_side(towards: np.ndarray, head: Mesh) -> None:
    centre = np.array([0.0, 1.6, 0.0])
    none = np.zeros((0, 3)), np.zeros(1, np.int32)
    shadow = cast_shadow(Light(towards, np.ones(3)), centre, 0.3, *none, 1e-3, head)
    aside = np.cross(towards, [0.3, -0.5, 0.8])
    aside /= np.linalg.norm(aside)
    hidden = [centre - 0.1 * towards, centre - 0.25 * towards, centre - 0.2 * towards + 0.08 * aside]
    lit = [centre + 0.09 * towards, centre + 0.2 * towards, centre - 0.2 * towards + 0.1 * aside]
    assert between(shadow, np.array(hidden)) == pytest.approx(SOLID)
    assert between(shadow, np.array(lit)) == pytest.approx(0.0)
