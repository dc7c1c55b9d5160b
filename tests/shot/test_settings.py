"""Settings of hair that contradict each other are refused when the graph file is read."""

import pytest

import hairpipe
from hairpipe.errors import BadInput

GRAPH = """schema = 1
frames = [1, 2]
fps = 24
[tuft]
type = "make_strands"
[hair]
type = "simulate_hair"
in.groom = "tuft"
"""


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "stiction = { reach = 2e-3, release = 1e-3 }",
            r"hair.*stiction: the release distance, 0.001 m, is not more than the reach, 0.002 m \(a larger release",
        ),
        ("curvature = 0.5\nsag_free = {}", r"\[hair\].*curvature = 0.5 contradicts sag_free, .*\(curvature = 1, or no"),
        ("curvature = 1.5", r"curvature = 1.5 is not allowed"),
    ],
)
def test_contradictions_are_refused(line, message):
    with pytest.raises(BadInput, match=message):
        hairpipe.load(GRAPH + line + "\n")
    assert hairpipe.load(GRAPH + "curvature = 0.5\nstiction = { reach = 2e-3, release = 3e-3 }\n")
