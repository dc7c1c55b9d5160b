"""Start of the exchange between strands: the motion of the stage before."""

import numpy as np

from hairpipe.sim.solve import pcg
from hairpipe.sim.solve.strand_coupling import StrandCoupling

MOTION = np.array([[1.0, -2.0, 0.5]], np.float32)


def starts_of(coupling, monkeypatch, solves):
    """Return what each solve expects; solves: duration of a new stage [s], or None: a further solve of the stage."""
    starts = []

    def solve(*_, expected):
        starts.append(None if expected is None else expected.copy())
        return pcg.Exchange(np.zeros_like(MOTION), MOTION.copy(), 3, 0.01)

    monkeypatch.setattr(pcg, "solve", solve)
    for span in solves:
        if span is not None:
            coupling.expect(span)
        coupling.exchange(lambda impulses, change: None, MOTION, np.ones(1))
    return starts


def test_a_stage_expects_the_motion_of_the_stage_before_in_proportion_to_time(monkeypatch):
    first, second, third = starts_of(StrandCoupling([]), monkeypatch, [0.004, 0.002, 0.003])
    assert first is None
    np.testing.assert_allclose(second, 0.5 * MOTION)
    np.testing.assert_allclose(third, 1.5 * MOTION)


def test_a_further_solve_of_a_stage_expects_nothing_and_adds_to_its_motion(monkeypatch):
    _, further, after = starts_of(StrandCoupling([]), monkeypatch, [0.004, None, 0.004])
    assert further is None
    np.testing.assert_allclose(after, 2.0 * MOTION)
