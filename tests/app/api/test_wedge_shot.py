"""All variants of a wedge in one run: what is shared, what is given up, and that keys are those of `--set`."""

import os
from collections import Counter
from pathlib import Path

import pytest

import hairpipe
from hairpipe.engine.file import wedge as wedge_file
from hairpipe.engine.file.wedge import variant_name
from hairpipe.errors import BadInput

pytestmark = pytest.mark.usefixtures("kept_workers")
WEIGHT = """
[weight]
type = "weigh"
in.number = "sum"
"""
WEDGE = """
[wedge.steps]
axes.move.step = [1.0, 2.0]
axes.sum.warn = [10, 11, 12]
measures = ["weight"]
"""
STOP = 'stop = [["weight.weight [kg]", ">", 35]]\n'


@pytest.fixture
def wedged(shot):
    """A shot of six variants: a movement of two kinds, and three sums of each."""
    shot.write_text(shot.read_text() + WEIGHT + WEDGE)
    return shot


def evaluated() -> Counter:
    """Count evaluations by node type since the last call."""
    path = Path(os.environ["TOY_TALLY"])
    lines = path.read_text().splitlines() if path.exists() else []
    path.unlink(missing_ok=True)
    return Counter(line.split()[0] for line in lines)


def keys(shot, names=None):
    """List the keys of all results, by what they are the results of in the graph file."""
    found = {target: record.key for target, record in shot.results().items()}
    return found if names is None else {target: found[merged] for target, merged in names.items()}


def test_common_results_of_variants_are_computed_once(wedged):
    report = hairpipe.load(wedged).wedge("steps").run(jobs=1)
    done = evaluated()
    assert (done["make_seed"], done["move_seed"], done["add_up"]) == (1, 2 * 6, 2 * 3 * 6)
    assert done["weigh"] == 2 * 6, "sums that warn at different frames are equal, and so is what is made of them"
    assert report.ok and report.outcome.evaluated == sum(done.values())
    assert report.progress["seed"].total == 1 and report.progress["move"].total == 2 * 6
    assert report.progress["sum"].total == 2 * 3 * 6


def test_making_a_wedge_costs_in_proportion_to_its_variants(shot, monkeypatch):
    """The wedges of the file are read once, not once more for each variant, which reads all of them."""
    named = []
    monkeypatch.setattr(wedge_file, "variant_name", lambda *given: named.append(1) or variant_name(*given))
    count = 40
    axis = f"axes.move.step = {{ from = 1, to = {count}, count = {count} }}"
    shot.write_text(f"{shot.read_text()}\n[wedge.steps]\n{axis}\n")
    assert len(hairpipe.load(shot).wedge("steps").variants) == count
    assert len(named) <= 3 * count


@pytest.mark.slow
def test_results_are_shared_with_runs_of_one_variant_both_ways(wedged):
    loaded = hairpipe.load(wedged)
    wedge = loaded.wedge("steps")
    one, other = wedge.variants["step=2,warn=11"], wedge.variants["step=1,warn=12"]
    loaded.run(set=one.settings, jobs=1)
    before = evaluated()
    assert before["add_up"] == 6 and wedge.run(jobs=1).progress["sum"].cached == 6
    assert evaluated()["move_seed"] == 6
    for variant in (one, other):
        alone = loaded.changed(variant.settings)
        assert {entry.status for entry in alone.plan()} == {"cached"}
        assert set(keys(alone).values()) <= set(keys(wedge).values())
        last = wedge.task(variant, "sum", 6)
        assert alone.get("sum@6").value == wedge.read(last, wedge.results()[str(last)]).value


def test_a_difference_that_begins_late_costs_what_comes_after_it(wedged):
    wedged.write_text(wedged.read_text().replace("axes.move.step = [1.0, 2.0]", "axes.move.turn = [3, 5, 9]"))
    hairpipe.load(wedged).wedge("steps").run(to="sum", jobs=1)
    sums = evaluated()["add_up"]
    assert sums == 3 * (6 + 4 + 2), "of a movement that turns at frame 3, at 5 and never the first 2 and 4 are the same"


def test_each_variant_is_published_in_its_own_folder(wedged):
    report = hairpipe.load(wedged).wedge("steps").run(jobs=1)
    assert len(report.outcome.published) == 6 * (1 + 6)
    lists = {path.parent.name: path.read_text() for path in Path("out").glob("*/list.txt")}
    assert set(lists) == set(hairpipe.load(wedged).wedges["steps"].variants) and len(set(lists.values())) == 2
    assert hairpipe.Cache("cache").clean([hairpipe.load(wedged)]).records == 0, "the wedges of a graph are kept"
    assert hairpipe.Cache("cache").clean().records > 0


def test_a_variant_that_fails_a_criterion_stops_and_the_others_continue(wedged):
    wedged.write_text(wedged.read_text() + STOP)
    wedge = hairpipe.load(wedged).wedge("steps")
    report = wedge.run(jobs=1)
    alone = hairpipe.load(wedged).changed({"move.step": 2.0}).run(to="sum", jobs=1)
    truth = [alone.get(f"sum@{frame}") for frame in range(1, 7)]
    frame = next(frame for frame, number in enumerate(truth, 1) if number.value > 35)
    assert report.ok and list(report.stopped) == [f"step=2,warn={warn}" for warn in (10, 11, 12)]
    assert wedge.survey().complete, "without the results of the stopped variants"
    value = f"{truth[frame - 1].value:.4g}"
    assert set(report.stopped.values()) == {f"weight.weight [kg] {value} > 35 at frame {frame}"}
    assert report.outcome.blocked == 0
    assert len(list(Path("out").glob("*/list.txt"))) == 3
    assert f"stopped: step=2,warn=10: weight.weight [kg] {value}" in repr(report)


def test_nothing_is_simulated_beyond_the_frame_that_fails_and_a_plan_knows(wedged):
    wedged.write_text(wedged.read_text() + STOP.replace("35", "20"))
    wedge = hairpipe.load(wedged).wedge("steps")
    report = wedge.run(to="list", jobs=2)
    last = {variant: int(why.split()[-1]) for variant, why in report.stopped.items()}
    assert len(last) == 6 and set(last.values()) == {4, 5}
    assert report.progress["sum"].evaluated + report.progress["sum"].cached == 3 * (4 + 5)
    assert evaluated()["add_up"] <= 3 * (4 + 5)
    plan = wedge.plan(to="list")
    assert {entry.status for entry in plan} == {"cached"} and plan.stopped == report.stopped
    assert wedge.run(to="list", jobs=1).stopped == report.stopped and not evaluated()


def test_a_plan_reports_what_would_run(wedged):
    wedge = hairpipe.load(wedged).wedge("steps")
    loaded = hairpipe.load(wedged)
    assert len(wedge.plan(to="move")) == 1 + 12 and not Path("cache").exists()
    loaded.run(set={"move.step": 2.0}, to="move", jobs=1)
    assert [entry.task.node for entry in wedge.plan(to="move") if entry.status == "cached"][1:] == ["move[step=2]"] * 6


def test_names_of_nodes_are_those_of_the_graph_file(wedged):
    wedge = hairpipe.load(wedged).wedge("steps")
    assert [entry.task.node for entry in wedge.plan("1", to="sum")].count("sum[step=1,warn=10]") == 1
    with pytest.raises(BadInput, match=r"no node 'sun' \(did you mean 'sum'\?\)"):
        wedge.plan(to="sun")


def test_settings_change_all_variants(wedged):
    changed = hairpipe.load(wedged).wedge("steps").changed({"seed.value": 5})
    assert [v.graph.nodes["seed"].settings["value"] for v in changed.variants.values()] == [5.0] * 6


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[1.0, 2.0]", "[1.0, -2.0]", r"\[wedge.steps\] step=-2,warn=10: .*shot.toml.*step = -2.0 is not allowed"),
        ("move.step", "move.stop", r"unknown setting 'stop' .*did you mean 'step'"),
        ("axes.move.step", "axes.seed.step", "unknown setting 'step'"),
        ("measures", 'stop = [["list.x", ">", 1]]\nmeasures', "'list' has one value for the shot"),
    ],
)
def test_a_bad_variant_is_refused_as_the_file_would_be(old, new, message, wedged):
    wedged.write_text(wedged.read_text().replace(old, new))
    with pytest.raises(BadInput, match=message):
        hairpipe.load(wedged).wedge("steps")


def test_a_criterion_on_a_column_that_is_not_there_names_the_nearest(wedged):
    wedged.write_text(wedged.read_text() + STOP.replace("weight [kg]", "wait [kg]"))
    with pytest.raises(BadInput, match=r"no column 'wait \[kg\]' \(did you mean 'weight \[kg\]'\?\)"):
        hairpipe.load(wedged).wedge("steps").run(jobs=1)


def test_a_variant_is_written_into_the_file(wedged):
    loaded = hairpipe.load(wedged)
    before = wedged.read_text()
    loaded.save(loaded.wedge("steps").variant("step=2,warn=12").settings)
    assert hairpipe.load(wedged).nodes["sum"].settings["warn"] == 12
    new = [line for line in wedged.read_text().splitlines() if line not in before.splitlines()]
    assert new == ["step = 2.0", "warn = 12"]
    with pytest.raises(BadInput, match="not a file of yours"):
        hairpipe.load("demo").save({"groom.strands": 5})
    with pytest.raises(BadInput, match="is not allowed"):
        loaded.save({"move.step": -1.0})
    assert hairpipe.load(wedged).nodes["move"].settings["step"] == 2.0


FRAMED = """schema = 1
frames = [1, 2]
fps = 24

[tuft]
type = "make_strands"
strands = 3
length = 0.1

[same]
type = "sample_groom"
in.groom = "tuft"

[hair]
type = "simulate_hair"
in.groom = "same"

[picture]
type = "preview"
in = { hair = "hair", framed = "same" }

[wedge.long]
axes.tuft.length = [0.1, 0.2, 0.3]
"""


def test_pictures_of_all_variants_are_framed_by_the_groom_of_the_graph_file(tmp_path):
    (tmp_path / "framed.toml").write_text(FRAMED)
    shot = hairpipe.load(tmp_path / "framed.toml", cache=tmp_path / "cache")
    wedge = shot.wedge("long")
    for variant in wedge.variants.values():
        picture = wedge.graph.nodes[variant.names["picture"]]
        assert picture.edges["framed"].node == "same[unvaried]"
        assert picture.edges["hair"].node == variant.names["hair"] != "hair"
    keys = {entry.task.node: entry.key for entry in wedge.plan()}
    own = {entry.task.node: entry.key for entry in shot.plan()}
    assert keys["same[unvaried]"] == own["same"] and keys["tuft[unvaried]"] == own["tuft"]
