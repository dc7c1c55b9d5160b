"""The order of roots keeps neighbours together."""

import numpy as np

from hairpipe.groom.ordering import order_along_curve


def test_it_is_an_order_and_follows_octants():
    points = np.random.default_rng(0).random((5000, 3))
    order = order_along_curve(points)
    assert np.array_equal(np.sort(order), np.arange(5000))
    low, high = points.min(axis=0), np.ptp(points, axis=0).max()
    octants = (((points - low) / high >= 0.5) * [1, 2, 4]).sum(axis=1)
    assert np.all(np.diff(octants[order]) >= 0)


def test_neighbours_in_space_are_near_in_the_order():
    points = np.random.default_rng(1).random((4096, 3)) * [1.0, 1.0, 0.0]
    place = np.argsort(order_along_curve(points))
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    closest = apart.argmin(axis=1)
    assert np.median(np.abs(place - place[closest])) <= 4


def test_none_one_and_many_in_one_place():
    assert len(order_along_curve(np.empty((0, 3)))) == 0
    assert order_along_curve(np.ones((1, 3))).tolist() == [0]
    assert order_along_curve(np.ones((4, 3))).tolist() == [0, 1, 2, 3]
