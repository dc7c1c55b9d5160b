"""Progress: counted from events alone."""

from types import SimpleNamespace

from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import Event, Progress

NODES = {
    name: SimpleNamespace(name=name, type=SimpleNamespace(mode=mode)) for name, mode in (("a", "each"), ("b", "scan"))
}


def progress():
    found = Progress(SimpleNamespace(nodes=NODES), jobs=4)
    found.update(Event("begun", totals=(("a", 10), ("b", 10))))
    return found


def test_time_left_is_the_median_of_recent_evaluations_over_the_width():
    found = progress()
    for frame in range(1, 5):
        for node in "ab":
            found.update(Event("started", Task(node, frame)))
            found.update(Event("finished", Task(node, frame), seconds=100.0 if frame == 1 else 2.0))
    assert found.nodes["b"].seconds_per_frame == 2.0
    assert found.nodes["b"].seconds_left == 12.0
    assert found.nodes["a"].seconds_left == 3.0
    assert found.nodes["a"].done == 4 and not found.nodes["a"].running


def test_nothing_is_promised_before_the_first_evaluation():
    found = progress()
    found.update(Event("cached", Task("a", 1), seconds=9.0))
    found.update(Event("started", Task("a", 2)))
    node = found.nodes["a"]
    assert (node.done, node.cached, node.seconds_left, node.running) == (1, 1, None, {Task("a", 2)})


def test_repeated_evaluations_count_once_and_failed_tasks_are_not_running():
    found = progress()
    for frame in [*range(1, 11), 3, 4]:
        found.update(Event("finished", Task("b", frame), seconds=1.0))
    assert found.nodes["b"].done == 10 and found.nodes["b"].seconds_left == 0.0
    found.update(Event("started", Task("a", 1)))
    found.update(Event("failed", Task("a", 1), message="no"))
    assert (found.nodes["a"].running, found.nodes["a"].done) == (set(), 0)


def test_a_line_names_the_time_of_an_evaluation_only():
    assert str(Event("finished", Task("a", 12), seconds=1.25)) == "a@12: finished in 1.2 s"
    assert str(Event("cached", Task("a", 12), seconds=1.25)) == "a@12: cached"
    assert str(Event("failed", Task("b", 1), message="no")) == "b@1: failed: no"
    assert str(Event("begun", totals=(("a", 1500), ("b", 10)))) == "begun: 1,510 results"
