"""What a solve of a rod costs, counted in its own source; nothing is compiled."""

import numpy as np

from hairpipe.graphs.experiments.bench.arithmetic.counting import count_work
from hairpipe.laws.stretch import SpringForm
from hairpipe.solve.implicit_stage import run_stage
from hairpipe.solve.stage import Iterate, Rule, Stage

MOST = 2400
"""Operations a segment that the network takes at half the length of a segment: a rod must be below."""


def test_a_segment_of_a_rod_costs_less_than_two_of_the_network(scene, straight):
    work = []
    for segments in (10, 20):
        hair = scene([straight(0.1, segments, [0.3, -1, 0.2])], model="rod").hair
        x, v, T = hair.rest.copy(), np.zeros_like(hair.rest), np.zeros_like(hair.model.inverse_lengths)
        ends = np.concatenate([hair.rest[:3], np.zeros_like(hair.rest[:3])])
        free, h = np.zeros((0, x.shape[2])), np.full((1, x.shape[2]), 1e-3)
        rule = Rule(int(SpringForm.multiplier), 0.0, 0.03, 1, np.array([0.0, -9.81, 0.0]), 0.1)
        stage = Stage(hair.rest, v.copy(), hair.rest, v.copy(), ends, free, h, 1e-3, 1e-3)
        work.append(count_work(run_stage, hair.model, 0, Iterate(x, v, T), stage, rule).operations)
    segment = (work[1] - work[0]) / 10
    assert 1000 < segment < MOST
