"""Hair with everything around it: the same whatever the threads, resumed or not, and finite by every scheme."""

from dataclasses import dataclass, replace

import numba
import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.formats.hdf5 import decode, digest, encode
from hairpipe.laws.settings import (
    Air,
    BodyContact,
    Collisions,
    Drag,
    Gusts,
    Scheme,
    Shielding,
    StepControl,
    Stiction,
    StrainLimit,
    Thickness,
    Wind,
)
from hairpipe.shot.build import with_interactions
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.solve.couplings import ACROSS, ALONG, DIRECTION, PUSH, Joined
from hairpipe.solve.interactions import Interaction
from hairpipe.values.hair import HairState

from ..strand_scenes import Solid, around


def ball_at(speed, begins=0.05):
    """A ball that goes along x from a place on that axis."""
    return Solid(lambda x, t: around(x - [begins + speed * t, -0.06, -0.0333], 0.04), (speed, 0.0, 0.0), speed)


EVERYTHING = Scene(
    air=Air(Drag(2.0)),
    contact=BodyContact(folds=0.5),
    strain=StrainLimit(),
    steps=StepControl(longest=1 / 120),
    stiction=Stiction(reach=1e-3, release=3e-3),
    collisions=Collisions(Thickness(8e-4)),
    wind=Wind((-2.0, 0.0, 0.0), gusts=Gusts(), shielding=Shielding()),
)


@pytest.fixture
def tuft(scene, straight):
    """Run a tuft for so many frames; give its states."""

    def run(frames, how=EVERYTHING, bodies=(ball_at(0.5),), state=None, strands=12):  # noqa: B008 (it has no state)
        roots = np.random.default_rng(7).normal(scale=2e-3, size=(strands, 3)) * [1, 0, 1]
        shot = scene([straight(0.1, 12, [1, 0.2 * k / strands, 0.1]) + root for k, root in enumerate(roots)])
        shot.scene = how
        shot.state = state or shot.state
        states = []
        for _ in range(frames):
            states.append(shot.run(1 / 24, bodies).state)
        return states

    return run


MOST_THREADS = numba.config.NUMBA_NUM_THREADS  # pyright: ignore[reportPrivateImportUsage, reportAttributeAccessIssue]
"""Which numba reads from the environment."""


@pytest.mark.skipif(MOST_THREADS < 2, reason="needs two threads")
@pytest.mark.parametrize(("frames", "strands"), [(3, 12), (1, 400)], ids=["few strands", "many chunks of points"])
def test_threads_change_no_bit(tuft, same_on_threads, frames, strands):
    same_on_threads(lambda: tuft(frames, strands=strands))


def test_a_run_that_is_resumed_gives_the_same_bytes(tuft, tmp_path):
    whole = tuft(3)
    assert len(whole[0].stuck) > 0 and len(whole[0].touching.points) > 0
    encode(whole[0], tmp_path / "state.h5")
    resumed = tuft(2, state=decode(tmp_path / "state.h5", HairState))
    assert digest(resumed[-1]) == digest(whole[-1])


@pytest.mark.parametrize("value", ["tr_bdf2", "bdf2", "backward_euler", "nine_steps"])
@pytest.mark.parametrize("solver", ["coupled", "sweep"])
def test_nothing_is_flung_about_by_any_scheme(tuft, value, solver):
    how = replace(EVERYTHING, scheme=Scheme(value=value), collisions=Collisions(Thickness(8e-4), solver=solver))
    last = tuft(6, how)[-1]
    assert np.isfinite(last.positions).all() and np.isfinite(last.velocities).all()
    assert np.abs(last.velocities).max() < 20.0


def test_absent_interactions_have_no_effect(tuft):
    """A body out of reach, and stiction and collisions of hair too far apart to meet."""
    alone = tuft(2, Scene(air=Air(Drag(2.0)), strain=StrainLimit(), steps=StepControl(longest=1 / 120)), bodies=())
    far = replace(EVERYTHING, stiction=Stiction(reach=1e-6, release=2e-6), collisions=Collisions(Thickness(1.1e-6)))
    met = tuft(2, replace(far, wind=None, contact=BodyContact(thickness=1e-6)), bodies=[ball_at(0.0, 5.0)])
    for one, other in zip(met, alone, strict=True):
        np.testing.assert_allclose(one.positions, other.positions, atol=1e-9)
        np.testing.assert_allclose(one.velocities, other.velocities, atol=1e-7)
        np.testing.assert_allclose(one.accelerations, other.accelerations, atol=1e-4)
        assert one.pace == other.pace and not len(one.stuck)


def test_prescribed_ends_are_at_their_places(scene, straight):
    """Also those of hair that is drawn out farther than its strain limit, into a body and into other hair."""
    shot = scene([straight(0.1, 12, [1, 0, 0.1 * k]) for k in range(4)])
    groom, offsets = shot.hair.groom, shot.hair.layout.offsets
    drawn = Track((0.0, 0.125), ((0.0, 0.0, 0.0), (0.006, 0.0, 0.0)))
    still, ball = Track(), ball_at(0.0)
    shot.state = start(shot.hair, drive(groom, 0.0, still, None, drawn, None), EVERYTHING)
    for frame in range(4):
        before, after = (drive(groom, time / 24, still, None, drawn, None) for time in (frame, frame + 1))
        shot.state = advance_frame(shot.hair, shot.state, (before, after), [ball], 1 / 24, EVERYTHING)
        for at, motions in ((offsets[:-1], after.roots), (offsets[1:] - 1, after.tips)):
            led = np.einsum("sij,sj->si", motions[:, :, :3], groom.points[at]) + motions[:, :, 3]
            np.testing.assert_allclose(shot.axis[at], led, atol=1e-12)
    # The last segment is held as a whole; the others share what is drawn out.
    assert np.linalg.norm(np.diff(shot.axis[:12], axis=0), axis=1).min() > 1.02 * 0.1 / 12


def test_steps_are_shorter_where_hair_would_pass_through_hair(tuft):
    """And only there: hair that may cross as it likes goes at the longest."""
    longest = 1 / 48
    paces = {}
    for crossings in (1e-3, 1e3):
        how = replace(EVERYTHING, steps=StepControl(longest=longest, crossings=crossings))
        paces[crossings] = min(state.pace for state in tuft(4, how))
    assert paces[1e-3] < 0.9 * longest
    assert paces[1e3] == longest


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
