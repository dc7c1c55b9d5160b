"""Values of particles and of strands, in lanes and in the order of the groom."""

import numpy as np
import pytest

from hairpipe.strands.layout import Layout, axis_of, lay_out, relaid
from hairpipe.strands.registry import strand_models

COUNTS = [4, 3, 4, 6, 3, 4, 4, 4, 4, 4, 4, 3]
"""Points of the strands of a groom: lanes are left over in every class."""


@pytest.fixture(scope="module")
def layout() -> Layout:
    offsets = np.cumsum([0, *COUNTS]).astype(np.int32)
    return lay_out(offsets, strand_models()["network"].shape)


def numbered(layout):
    """Number all particles by strand and place; lanes that repeat a strand have its numbers."""
    lanes = layout.empty(3)
    for block in range(layout.blocks):
        rows = np.arange(layout.first[block + 1] - layout.first[block])
        numbers = 100.0 * layout.strands[block] + rows[:, None]
        lanes[layout.first[block] : layout.first[block + 1]] = numbers[:, None] + 0.1 * np.arange(3)[None, :, None]
    return lanes


def test_points_have_the_values_of_their_particles(layout):
    shape, lanes = layout.shape, numbered(layout)
    expected = [
        [100.0 * strand + shape.clamped - 1 + shape.stride * n + 0.1 * c for c in range(3)]
        for strand, count in enumerate(COUNTS)
        for n in range(count)
    ]
    np.testing.assert_allclose(layout.axis(lanes), expected)
    np.testing.assert_allclose(axis_of(layout).gather(lanes), expected)


def test_points_have_the_values_of_their_strands(layout):
    axis = axis_of(layout)
    of_points = np.repeat(np.arange(len(COUNTS)), COUNTS)
    values = layout.strands.astype(float)
    np.testing.assert_array_equal(axis.gather(values), of_points)
    np.testing.assert_array_equal(axis.gather(values, np.empty(len(of_points), bool)), of_points != 0)
    active = (layout.strands == 5).astype(float)
    one = axis.gather(values, np.full(len(of_points), -1.0), active=active)
    np.testing.assert_array_equal(one, np.where(of_points == 5, 5, -1))


def test_scattered_points_are_gathered_again(layout):
    axis, points = axis_of(layout), np.random.default_rng(0).normal(size=(sum(COUNTS), 3))
    lanes = np.full_like(layout.empty(3), np.nan)
    axis.scatter(points, lanes)
    np.testing.assert_array_equal(axis.gather(lanes), points)
    assert np.isnan(lanes).any(), "those off the axis are unchanged"
    marked = np.zeros(len(points), bool)
    marked[[3, 4, -1]] = True
    strands = np.empty(layout.strands.shape)
    axis.scatter(marked, strands)
    np.testing.assert_array_equal(strands, np.isin(layout.strands, [0, 1, 11]))


def test_classes_of_strands_are_gathered_and_scattered(layout):
    particles, strands = numbered(layout), layout.strands[:, None].astype(float)
    for values in (particles, strands):
        out = np.empty_like(values)
        for blocks in layout.classes():
            layout.scatter(layout.gather(values, blocks), blocks, out)
        np.testing.assert_array_equal(out, values)
    blocks = next(layout.classes())
    np.testing.assert_array_equal(layout.gather(strands, blocks)[:, 0, 0], layout.strands[blocks].ravel())
    assert len(layout.gather(particles, blocks)[0]) == layout.shape.count(2)


def test_another_layout_has_the_same_values(layout):
    single = lay_out(layout.offsets, layout.shape, np.float32)
    assert single.width != layout.width
    for values, expected in (
        (numbered(layout), numbered(single).astype(float)),
        (layout.strands.astype(float), single.strands),
    ):
        np.testing.assert_allclose(relaid(values, layout, single), expected, rtol=1e-6)
