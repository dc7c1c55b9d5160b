"""Functions that kernels inline."""

import pickle

from numba import njit

from hairpipe.geometry.compile import Inlined, inlined


@inlined
def twice(x):
    return 2 * x


@njit
def doubled(x):
    return twice(x) + twice(3)


def test_a_literal_is_compiled_as_any_number_of_its_type():
    assert doubled(4) == 14
    assert len(twice.signatures) == 1


def test_python_may_call_one():
    assert twice(1.5) == 3.0


def test_inlined_function_is_rebuilt_in_another_process():
    """Cached kernels refer to the functions in them."""
    states = pickle.loads(pickle.dumps(twice._reduce_states() | {"uuid": "another process", "py_func": None}))
    again = Inlined._rebuild(**states | {"py_func": twice.py_func})
    assert isinstance(again, Inlined) and again is not twice
    assert again.targetoptions == twice.targetoptions
