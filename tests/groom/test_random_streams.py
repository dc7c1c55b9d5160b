"""Random numbers by purpose."""

import numpy as np

from hairpipe.values.random_streams import stream


def test_the_same_purpose_draws_the_same_numbers():
    assert np.array_equal(stream(3, "length").random(5), stream(3, "length").random(5))


def test_another_purpose_or_seed_draws_others():
    draws = {tuple(stream(seed, purpose).random(4)) for seed in (0, 1, 12) for purpose in ("length", "lift", "2/lift")}
    assert len(draws) == 9
