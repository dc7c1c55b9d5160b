"""Strands that begin in another shape than that of their rest."""

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.engine import Pair, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.simulate_bent import model_bent, simulate_bent
from hairpipe.groom.strands import lay_strands
from hairpipe.shot.settings import HairSettings

SETTINGS = HairSettings(model="rod", gravity=0.0, precision="double")
CHANGED = {name: getattr(SETTINGS, name) for name in ("model", "gravity", "precision")}


def strand(arch, segments=10):
    """Lay a strand of 10 cm with an arch."""
    return lay_strands(1, 0.1, segments, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, arch)


def ends_of(groom, rest, frames):
    """Return the points of a strand with a rest shape at the first and at the last of some frames."""
    model = model_bent(groom, rest, SETTINGS.material, SETTINGS.model, SETTINGS.construction)
    ends = drive(groom, 0.0, Track(), None, None, None)
    state, seen = None, []
    for frame in range(frames):
        hair = simulate_bent(groom, rest, Pair(ends, ends), state, Time(frame, 24.0), model, **CHANGED)
        state = hair.state
        seen.append(hair.strands.points)
    return seen[0], seen[-1]


def bow(points):
    """Return how much nearer the ends of a strand are than it is long, as a part of its length."""
    return 1.0 - np.linalg.norm(points[-1] - points[0]) / np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def test_a_bent_strand_straightens_to_its_rest_shape_and_a_groom_stays():
    arched = strand(0.4)
    begun, ended = ends_of(arched, strand(0.0), 13)
    assert begun == pytest.approx(arched.points) and bow(begun) > 0.1
    assert bow(ended) < 0.01 * bow(begun)
    _, kept = ends_of(arched, arched, 3)
    assert kept == pytest.approx(arched.points, abs=1e-9)


def test_a_rest_shape_of_another_cut_is_refused():
    with pytest.raises(BadInput, match="other strands or segments"):
        model_bent(strand(0.4), strand(0.0, 9), SETTINGS.material, SETTINGS.model, SETTINGS.construction)
