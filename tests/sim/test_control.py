"""Steps are as short as what moves asks for."""

import numpy as np
import pytest

from hairpipe.sim.control import Travel, next_step
from hairpipe.sim.motion import Motion
from hairpipe.sim.roots import Path

FRAME = 1 / 24


class Around:
    """Surroundings of which only the speed of bodies counts."""

    def __init__(self, speed):
        self.speed = speed

    def body_speed(self):
        return self.speed


def step(hair, body, distance=0.02):
    v = np.zeros((3, 3, 8))
    v[2, 1, 5] = hair
    motion = Motion(np.zeros_like(v), v, np.zeros_like(v), np.zeros((3, 3, 8)))
    nothing = np.zeros((1, 4, 3, 8))
    return next_step([Travel(distance, Around(body))], motion, Path(nothing, nothing, FRAME), 0.0)


@pytest.mark.parametrize(("hair", "body", "steps"), [(0.0, 0.0, 1), (0.4, 0.1, 1), (1.2, 0.1, 3), (0.1, 1.9, 4)])
def test_neither_hair_nor_a_body_goes_farther_than_it_may(hair, body, steps):
    assert step(hair, body) == pytest.approx(FRAME / steps)
