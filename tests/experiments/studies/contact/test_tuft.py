"""Fig. 13 in small: a tuft in a fast head motion, as soft springs, as our model, and as one that touches itself."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.planner import read_result
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store

TUFT = Path(__file__).resolve().parents[4] / "graphs" / "experiments" / "tuft.toml"
SMALL = {"tuft.strands": "5", "tuft.tuft.rows": "5", "tuft.segments": "12"}
FRAMES = range(1, 17)
pytestmark = pytest.mark.kernels


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Give a table, by the measure and the model; every frame is a row."""
    graph = load_graph(TUFT, SMALL)
    names = [f"motion_{model}" for model in ("plain", "ours", "touching")]
    graph, store = graph.upto(names), Store(tmp_path_factory.mktemp("tuft") / "cache")
    assert not run(graph, store, FRAMES, Options(jobs=1)).failures
    return {name: read_result(graph, store, Task(name, None), None, FRAMES) for name in names}


def test_soft_springs_stretch_and_our_model_does_not(tables):
    stretch = {model: tables[f"motion_{model}"]["longest stretch [%]"].max() for model in ("plain", "ours", "touching")}
    assert stretch["plain"] > 50.0 and stretch["ours"] < 2.0 and stretch["touching"] < 2.0


def test_touching_tuft_stays_together(tmp_path):
    """In the median of three tufts that differ by half a percent: hair in contact is chaotic."""
    shares = [share_of_spread(stray, Store(tmp_path / "cache")) for stray in (3.96, 3.98, 4.0, 4.02, 4.04)]
    assert np.median(shares) < 0.3


def share_of_spread(stray, store):
    """Spread of the tips of a tuft that touches itself, over that of one that does not."""
    graph = load_graph(TUFT, SMALL | {"tuft.tuft.stray": str(stray)}).upto(["tuft_ours", "tuft_touching"])
    assert not run(graph, store, FRAMES, Options(jobs=1)).failures
    apart, together = (
        read_result(graph, store, Task(f"tuft_{model}", None), None, FRAMES)["spread of tips [mm]"][-1]
        for model in ("ours", "touching")
    )
    return together / apart
