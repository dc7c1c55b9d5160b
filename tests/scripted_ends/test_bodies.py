"""A body carried along keys moves as they say."""

import numpy as np

from hairpipe.data import Mesh
from hairpipe.scripted_ends.bodies import carried
from hairpipe.scripted_ends.track import Track


def test_it_is_where_the_keys_say_and_its_velocities_are_the_derivative(box):
    mesh = box()
    track = Track(
        (0.0, 1.0), ((0.0, 0.0, 0.0), (0.3, -0.1, 0.2)), (0.0, 200.0), (1.0, 2.0, 0.5), (0.2, 0.0, 0.1), "smooth"
    )
    for time in (-0.3, 0.2, 0.7, 1.5):
        now, (before, after) = carried(mesh, track, time), (carried(mesh, track, time + t) for t in (-1e-6, 1e-6))
        assert now.velocities is not None
        np.testing.assert_allclose(now.velocities, (after.points - before.points) / 2e-6, atol=1e-8)
    np.testing.assert_array_equal(carried(mesh, track, -0.3).points, mesh.points)


def test_a_turn_is_about_a_place_in_space(box):
    turned = carried(box(), Track((0.0,), turn=(90.0,), axis=(0.0, 0.0, 1.0), pivot=(1.0, 0.0, 0.0)), 0.0)
    x, y, z = box().points.T
    np.testing.assert_allclose(turned.points, np.stack([1.0 - y, x - 1.0, z], axis=1), atol=1e-14)


def test_a_mesh_that_moves_by_itself_goes_on_doing_so(box):
    track = Track((0.0, 1.0), ((0.0, 0.0, 0.0), (0.3, -0.1, 0.2)), (0.0, 200.0), (1.0, 2.0, 0.5), (0.2, 0.0, 0.1))
    still, speed = box(), np.array([2.0, -0.5, 0.3])

    def at(time):
        moving = Mesh(still.points + time * speed, still.triangles, np.tile(speed, (len(still.points), 1)))
        return carried(moving, track, time)

    now, before, after = (at(0.4 + t) for t in (0.0, -1e-6, 1e-6))
    np.testing.assert_allclose(now.velocities, (after.points - before.points) / 2e-6, atol=1e-8)
