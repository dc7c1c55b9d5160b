"""Which ready task takes which slot: scans first on wide ones, none waits for another; where a task is tried again."""

from collections import Counter, defaultdict, deque
from types import SimpleNamespace
from typing import Any

import pytest

from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import Failure
from hairpipe.engine.run.scheduler import MOST_LOSSES, Queue, Scheduler


@pytest.fixture
def begun(shot):
    """Give what a scheduler begins with free slots, (task, wide), of tasks that are ready in this order."""
    graph = shot.load()

    def begun(ready, **free):
        scheduler: Any = Scheduler.__new__(Scheduler)
        found = []
        scheduler.queue, scheduler.agenda, scheduler.limits = Queue(graph), deque(), {}
        scheduler.engine = SimpleNamespace(slots=lambda: SimpleNamespace(**free))

        def begin(task, wide):
            found.append((str(task), "wide" if wide else "narrow"))
            free["wide" if wide else "narrow"] -= 1

        scheduler.begin = begin
        for task in ready:
            scheduler.queue.push(task)
        scheduler.dispatch()
        return found

    return begun


SEED, MOVE, SUM = Task("seed", None), Task("move", 3), Task("sum", 2)


def test_a_value_of_the_shot_takes_a_wide_slot_or_a_narrow_one_while_none_is_free(begun):
    assert begun([SEED], wide=1, narrow=1) == [("seed", "wide")]
    assert begun([SEED], wide=0, narrow=1) == [("seed", "narrow")]
    assert begun([SEED], wide=0, narrow=0) == []


def test_scans_come_before_values_of_the_shot_and_take_wide_slots_only(begun):
    assert begun([SEED, SUM], wide=1, narrow=0) == [("sum@2", "wide")]
    assert begun([SUM], wide=0, narrow=4) == []


def test_values_of_frames_take_narrow_slots_in_the_order_of_frames(begun):
    later = [Task("move", frame) for frame in (9, 4, 6)]
    assert begun([*later, MOVE], wide=1, narrow=3) == [(f"move@{frame}", "narrow") for frame in (3, 4, 6)]


def test_a_task_may_find_its_inputs_damaged_so_often_and_fails_then():
    scheduler: Any = Scheduler.__new__(Scheduler)
    failures: list[Any] = []
    scheduler.losses, scheduler.fail, scheduler.store = Counter(), failures.append, SimpleNamespace(root="cache")
    for _ in range(MOST_LOSSES):
        assert scheduler.may_retry(MOVE) and not failures
    assert scheduler.may_retry(SUM)
    assert not scheduler.may_retry(MOVE)
    assert [(failure.task, failure.kind) for failure in failures] == [(MOVE, "disk")]


class Elsewhere:
    """A scheduler with machines that fail; what it submits again."""

    def __init__(self, *machines: str) -> None:
        self.machines = set(machines)
        self.again: list[Task] = []
        self.scheduler: Any = Scheduler.__new__(Scheduler)
        self.scheduler.engine = SimpleNamespace(machines=self.machines, leave_out=self.machines.discard)
        self.scheduler.queue = SimpleNamespace(push=self.again.append)
        self.scheduler.failed_at, self.scheduler.reported = defaultdict(set), set()
        self.scheduler.report = lambda event: None

    def fails(self, kind, machine, task=MOVE):
        """Let a task fail on a machine; whether it goes to another."""
        return self.scheduler.goes_elsewhere(Failure(task, kind, "no"), machine)


def test_a_task_whose_machine_crashed_or_is_gone_goes_to_another_once():
    hosts = Elsewhere("a", "b", "c")
    assert hosts.fails("crash", "a") and hosts.again == [MOVE] and hosts.machines == {"a", "b", "c"}
    assert not hosts.fails("gone", "b") and hosts.again == [MOVE]
    assert hosts.fails("gone", "a", SUM), "each task for itself"
    assert not Elsewhere("a").fails("crash", "a")


def test_a_machine_with_other_code_is_left_out_and_the_rest_goes_on():
    hosts = Elsewhere("a", "b", "c")
    assert hosts.fails("mismatch", "a") and hosts.fails("mismatch", "c")
    assert hosts.machines == {"b"} and hosts.again == [MOVE, MOVE]
    assert not hosts.fails("mismatch", "b")


@pytest.mark.parametrize("kind", ["input", "node", "diverged", "disk", "publish"])
def test_a_task_that_fails_by_itself_stays_failed(kind):
    hosts = Elsewhere("a", "b")
    assert not hosts.fails(kind, "a") and not hosts.again
