"""Threads of a context."""

import numba
import pytest

from hairpipe.geometry.compile import POINTS_A_THREAD, threads_for


def test_threads_follow_the_points_and_come_back_after_an_error():
    most = numba.get_num_threads()
    for points, threads in ((0, 1), (POINTS_A_THREAD - 1, 1), (POINTS_A_THREAD, 2), (10**9, most)):
        with pytest.raises(ArithmeticError), threads_for(points):
            assert numba.get_num_threads() == min(threads, most)
            raise ArithmeticError
        assert numba.get_num_threads() == most
