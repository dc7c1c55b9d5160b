"""Which ready task takes which slot, scans first on wide ones, none waiting for another; how often one is tried."""

from collections import Counter, deque
from types import SimpleNamespace
from typing import Any

import pytest

from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.run.scheduler import MOST_LOSSES, Queue, Scheduler


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
