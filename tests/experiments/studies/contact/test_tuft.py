"""Fig. 13 in small: a tuft in a fast head motion, as soft springs, as our model, and as one that touches itself."""

from pathlib import Path

import pytest

from hairpipe.graph.file.load import load_graph
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.results import read_result
from hairpipe.graph.run.events import Options
from hairpipe.graph.run.scheduler import run
from hairpipe.graph.store.store import Store

TUFT = Path(__file__).resolve().parents[4] / "graphs" / "experiments" / "tuft.toml"
SMALL = {"tuft.strands": "5", "tuft.tuft.rows": "5", "tuft.segments": "12"}
FRAMES = range(1, 17)
pytestmark = pytest.mark.kernels


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Give a table, by the measure and the model; every frame is a row."""
    graph = load_graph(TUFT, SMALL)
    names = [f"{measure}_{model}" for measure in ("motion", "tuft") for model in ("plain", "ours", "touching")]
    graph, store = graph.upto(names), Store(tmp_path_factory.mktemp("tuft") / "cache")
    assert not run(graph, store, FRAMES, Options(jobs=1)).failures
    return {name: read_result(graph, store, Task(name, None), None, FRAMES) for name in names}


def test_soft_springs_stretch_and_our_model_does_not(tables):
    stretch = {model: tables[f"motion_{model}"]["longest stretch [%]"].max() for model in ("plain", "ours", "touching")}
    assert stretch["plain"] > 50.0 and stretch["ours"] < 2.0 and stretch["touching"] < 2.0


def test_touching_tuft_stays_together(tables):
    apart, together = (tables[f"tuft_{model}"]["spread of tips [mm]"][-1] for model in ("ours", "touching"))
    assert together < 0.5 * apart  # 0.3 to 0.4 with small changes of contact: chaos
