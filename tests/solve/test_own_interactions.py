"""Forces of one's own, handed to a simulation by its scene: no file of the house knows them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from hairpipe.laws.settings import Scheme
from hairpipe.shot.build import with_interactions
from hairpipe.shot.simulate import advance_frame
from hairpipe.solve.couplings import ACROSS, ALONG, DIRECTION, PUSH, Joined
from hairpipe.solve.interactions import Interaction

FRAME = 1 / 24


@dataclass(eq=False)
class Spring(Interaction):
    """A spring from one point of hair to a place that moves along x, by so much at most [m], at a rate [m/s]."""

    point: int
    k: float
    start: np.ndarray
    way: float
    rate: float = 0.01

    def place(self, seconds):
        return self.start + np.array([min(self.rate * seconds, self.way), 0.0, 0.0])

    def linearise(self, at, push, damping):
        k, p = self.k, self.point
        h = at.weights[p]
        push[p] += k * (self.place(at.seconds) - at.points[p] + h * at.velocities[p])
        damping[p, [0, 3, 5]] += k * h


@dataclass(eq=False)
class Tie(Interaction):
    """A damper between two segments, at their ends, that lets them go apart by nothing."""

    couples = True
    segments: tuple[int, int]
    c: float

    @property
    def places(self):
        return Joined(np.array([self.segments], np.int32), np.array([[1.0, 1.0]]))

    def couple(self, at, couplings):
        one, other = (at.velocities[k + 1] for k in self.segments)
        c = at.span * self.c
        couplings.acts[:] = True
        couplings.exerted[0, DIRECTION : DIRECTION + 3] = [1.0, 0.0, 0.0]
        couplings.exerted[0, PUSH : PUSH + 3] = -c * (one - other)
        couplings.exerted[0, [ALONG, ACROSS]] = c


def run(shot, frames):
    """Run a shot in its time; give its points frame by frame."""
    found = []
    for n in range(frames):
        drivers = (shot.body, shot.body)
        shot.state = advance_frame(shot.hair, shot.state, drivers, (), FRAME, shot.scene, n * FRAME)
        found.append(shot.axis)
    return found


@pytest.mark.parametrize("scheme", [Scheme(), Scheme("nine_steps")], ids=lambda scheme: scheme.value)
def test_a_spring_draws_hair_as_far_as_both_are_stiff(scene, straight, scheme):
    """Two springs in a row, of which the hair is one: E A / L e = k (d - e), on the way and at its end."""
    shot = scene([straight(0.1, 10, [1, 0, 0])], model="chain", gravity=0.0, drag=20.0, scheme=scheme)
    axial, tip = shot.hair.model.constants[0, 0, 0] / 0.1, shot.axis[-1]
    spring = Spring(len(shot.axis) - 1, 0.5 * axial, tip, 1e-3)
    shot.scene = with_interactions(replace(shot.scene, strain=None), spring)
    moved = [points[-1] - tip for points in run(shot, 8)]
    expected = [(spring.place((n + 1) * FRAME) - tip) / 3.0 for n in range(8)]
    np.testing.assert_allclose(moved[1:], expected[1:], atol=0.02 * 1e-3)


@pytest.mark.parametrize("tied", [False, True])
def test_coupled_strands_move_together(scene, straight, tied):
    shot = scene([straight(0.1, 12, [0, -1, 0]), straight(0.1, 12, [0, -1, 0.1])], drag=20.0)
    start = shot.axis
    pull = Spring(12, 1e-2, start[12], 0.1, rate=0.1)
    shot.scene = with_interactions(shot.scene, pull, *([Tie((11, 24), 1e-1)] if tied else []))
    first, second = (run(shot, 6)[-1] - start)[[12, 25], 0]
    assert first > 0.02
    assert second == pytest.approx(first, rel=0.1) if tied else abs(second) < 0.05 * first
