"""What moves while the shutter is open leaves a trace as long as its way, as dark as it stays."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera, Shot
from hairpipe.render.film import MOST, instants
from hairpipe.values import Mesh, Strands

from .conftest import draw_portrait

CAMERA = Camera.look_at(np.array([0.0, 1.6, 1.0]), np.array([0.0, 1.6, 0.0]), 40.0, 160, 160)
BROWN = np.array([0.12, 0.06, 0.03])


def moving(hair: Strands, velocity: np.ndarray) -> Strands:
    return replace(hair, velocities=np.broadcast_to(velocity, hair.points.shape).astype(np.float32))


def test_instants_cover_the_time_evenly_and_body_and_hair_move_together(hair: Strands, head: Mesh) -> None:
    velocity = np.array([3.0, -1.0, 0.5])
    flying = replace(head, velocities=np.tile(velocity, (len(head.points), 1)))
    taken = list(instants(moving(hair, velocity), flying, CAMERA, 0.02))
    ways = np.array([(points - hair.points).mean(axis=0) for points, _ in taken]) / velocity
    assert 4 < len(taken) <= MOST
    middles = 0.02 * ((np.arange(len(taken)) + 0.5) / len(taken) - 0.5)
    assert ways == pytest.approx(np.tile(middles[:, None], (1, 3)), abs=0.02 * 0.04 / len(taken))
    for middle, (points, body) in zip(middles, taken, strict=True):
        assert body.points == pytest.approx(head.points + middle * velocity)
        late = (points - hair.points) @ velocity / (velocity @ velocity) - middle
        assert np.abs(late).max() <= 0.5 * 0.02 / len(taken) + 1e-6


def test_hair_at_rest_is_as_sharp_as_with_no_shutter(hair: Strands, head: Mesh) -> None:
    sharp, blurred = (draw_portrait(hair, head, Shot(80, 80), BROWN, 1.0, shutter=shutter) for shutter in (0.0, 0.02))
    assert np.array_equal(sharp, blurred)


def test_a_blurred_picture_is_the_mean_of_many_sharp_ones(hair: Strands) -> None:
    """Hair that moves by a third of the picture; about, for light is added before it is compressed, here after."""
    velocity, shot = np.array([0.0, 4.0, 0.0]), Shot(60, 60, eye=(0.0, 1.6, 1.5), target=(0.0, 1.6, 0.0))
    blurred = draw_portrait(moving(hair, velocity), None, shot, BROWN, 1.0, shutter=0.05).astype(float)
    times = 0.05 * ((np.arange(24) + 0.5) / 24 - 0.5)
    parts = [replace(hair, points=(hair.points + t * velocity).astype(np.float32)) for t in times]
    mean = np.mean([draw_portrait(part, None, shot, BROWN, 1.0).astype(float) for part in parts], axis=0)
    sharp = draw_portrait(hair, None, shot, BROWN, 1.0)
    assert np.abs(blurred - mean).mean() < 0.4 * np.abs(sharp - mean).mean()


def test_velocities_that_are_not_finite_are_refused(hair: Strands, head: Mesh) -> None:
    with pytest.raises(BadInput, match="a velocity is not finite"):
        list(instants(moving(hair, np.array([np.nan, 0.0, 0.0])), head, CAMERA, 0.02))
