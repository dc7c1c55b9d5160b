"""What a simulation costs is asked of the simulation that is meant."""

import inspect

import numba
import numpy as np
import pytest
from hairpipe.graphs.experiments.nodes.time_hair import time_hair
from hairpipe.graphs.experiments.nodes.time_particles import time_particles
from hairpipe.nodes.restart_hair import restart_hair
from hairpipe.nodes.simulate_hair import simulate_hair
from hairpipe.nodes.simulate_particles import simulate_particles

from hairpipe.errors import BadInput
from hairpipe.graph import Frames, Time
from hairpipe.groom.strands import lay_strands
from hairpipe.measure.cost import Around
from hairpipe.scripted_ends.ends import lead
from hairpipe.scripted_ends.track import Track
from hairpipe.sim.settings import Collisions, StepControl

GROOM = lay_strands(9, 0.05, 4, (0.0, -1.0, 0.0), (0.01, 0.0, 0.0), None, 0.0)


@pytest.mark.parametrize(
    ("node", "simulation"),
    [(time_hair, simulate_hair), (restart_hair, simulate_hair), (time_particles, simulate_particles)],
)
def test_it_takes_the_settings_of_the_simulation(node, simulation):
    ours, theirs = (inspect.signature(function).parameters for function in (node, simulation))
    settings = {name: (p.annotation, p.default) for name, p in theirs.items() if p.kind is p.KEYWORD_ONLY}
    assert settings.items() <= {name: (p.annotation, p.default) for name, p in ours.items()}.items()


def test_frames_are_timed_on_one_thread_and_particles_counted():
    threads = numba.get_num_threads()
    table = time_hair(GROOM, None, None, None, None, Time(1, 24.0), (), warm=1, timed=3)
    assert numba.get_num_threads() == threads
    assert 0.0 < table["fastest frame [s]"][0] <= table["seconds per frame"][0] <= table["slowest frame [s]"][0]
    assert table["frames timed"].tolist() == [3] and table["particles"].tolist() == [9 * 11]


def test_more_steps_cost_more():
    few, many = (
        time_hair(GROOM, None, None, None, None, Time(1, 24.0), (), steps=StepControl(1 / rate), warm=1, timed=5)
        for rate in (24, 2400)
    )
    assert many["seconds per frame"][0] > 5 * few["seconds per frame"][0]


@pytest.mark.parametrize("collisions", [None, Collisions()])
def test_a_run_that_diverges_ends_there_also_where_hair_touches_hair(collisions):
    table = time_hair(GROOM, None, None, None, None, Time(1, 24.0), (), gravity=1e300, collisions=collisions, timed=3)
    assert np.isnan(table["seconds per frame"][0]) and table["frames timed"].tolist() == [0]


@pytest.mark.parametrize("count", [1, 2])
def test_a_shot_of_few_frames_is_timed_as_far_as_it_goes(count):
    shot = Frames(tuple(range(5, 5 + count)), lambda frame: lead(GROOM, frame / 24, Track(), None, None, None))
    table = time_hair(GROOM, None, None, None, shot, Time(5, 24.0), (), warm=4, timed=8)
    assert table["frames timed"].tolist() == [count - 1]


def test_frames_that_are_left_out_are_refused_where_they_would_be_timed():
    shot = Frames((5, 6, 9), lambda frame: lead(GROOM, frame / 24, Track(), None, None, None))
    assert Around(None, shot, (), ()).frames(5, 2) == [5, 6]
    with pytest.raises(BadInput, match=r"no frames between 6 and 9.*\(4 of them in a row\)"):
        time_hair(GROOM, None, None, None, shot, Time(5, 24.0), (), warm=1, timed=2)
