"""Sets of frames as people write them."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hairpipe.engine.file.read import fold_frames, parse_frames
from hairpipe.errors import BadInput


def test_ranges_steps_and_single_frames():
    assert parse_frames("1-7x2, 150 ,5,-3--1") == (-3, -2, -1, 1, 3, 5, 7, 150)
    assert fold_frames([1, 3, 5, 7, 150, 151]) == "1-7x2,150-151"
    assert fold_frames([]) == ""


@given(st.sets(st.integers(-50, 50), min_size=1))
def test_folding_is_undone_by_parsing(numbers):
    assert parse_frames(fold_frames(numbers)) == tuple(sorted(numbers))


@pytest.mark.parametrize(
    "text", ["", "a", "1-", "1..5", "5-1", "1-5x0", "1,,2", "1-9999999", "1-5x", "1x2", "9" * 5000]
)
def test_anything_else_is_refused(text):
    with pytest.raises(BadInput):
        parse_frames(text)


@given(st.text(max_size=20))
def test_text_is_frames_or_refused(text):
    with suppress(BadInput):
        parse_frames(text)
