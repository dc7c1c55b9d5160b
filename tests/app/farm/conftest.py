"""The toy shot of the command line, with a wedge and a file that needs frames after the scan."""

import pytest

from ..cli.conftest import hairpipe, shot  # noqa: F401

WEDGE = """
[soft]
type = "soften"
in.number = "sum"
[total]
type = "gather"
in.numbers = "seed"
in.shots = "soft"
[wedge.steps]
axes.move.step = [1.0, 2.0]
"""


@pytest.fixture
def wedged(shot):  # noqa: F811
    """The shot with a wedge of two variants."""
    shot.write_text(shot.read_text() + WEDGE)
    return shot
