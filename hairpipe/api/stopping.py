"""Stop variants of a wedge: each frame of a measure is compared with the wedge's criteria once it is computed."""

import json
from collections.abc import Mapping, Sequence

from hairpipe.data import Table
from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.file.wedge import Comparison
from hairpipe.graph.node.messages import nearest
from hairpipe.graph.plan.tasks import Task, is_beyond
from hairpipe.graph.results import read_value
from hairpipe.graph.run.events import Judge
from hairpipe.graph.store.record import Record
from hairpipe.graph.store.store import Store


class Stopping(Judge):
    """Stopped variants, with frame and reason.

    Frames up to the one that fails a criterion are computed: it does not depend on the order of tasks.

    graph     of all variants
    criteria  comparisons of columns of measures with a value per frame
    variants  names of the nodes of every variant in the graph, by their names in the graph file
    """

    def __init__(
        self, graph: Graph, store: Store, criteria: Sequence[Comparison], variants: Mapping[str, Mapping[str, str]]
    ) -> None:
        self._graph, self._store, self._variants = graph, store, variants
        self._criteria: dict[str, list[Comparison]] = {}
        self._users: dict[str, list[str]] = {}
        for variant, names in variants.items():
            for name in names.values():
                self._users.setdefault(name, []).append(variant)
            for criterion in criteria:
                self._criteria.setdefault(names[criterion.node], []).append(criterion)
        self.judged = frozenset(self._criteria)
        self._found: dict[str, tuple[int, str]] = {}
        self._limits: dict[str, int] = {}

    def limits(self, task: Task, record: Record) -> Mapping[str, int]:
        """Check a result; return the frames beyond which nodes are stopped, by name. BadInput for a missing column."""
        for criterion in self._criteria.get(task.node, ()):
            assert task.frame is not None, "checked when the wedge was read"
            why = broken(criterion, read_table(self._graph, self._store, task, record))
            if why is not None:
                self._give_up(task, f"{why} at frame {task.frame}")
        return self._limits

    def gives_up(self, task: Task) -> bool:
        """Whether all variants of a task are stopped, and the task is beyond the last frame of these."""
        return is_beyond(task, self._limits)

    def stopped(self) -> dict[str, str]:
        """Return the reasons for stopped variants, by name, in the order of the wedge."""
        return {variant: self._found[variant][1] for variant in self._variants if variant in self._found}

    def frame_of(self, variant: str) -> int | None:
        """Return the frame at which a variant was stopped; None where it was not."""
        return self._found[variant][0] if variant in self._found else None

    def _give_up(self, task: Task, why: str) -> None:
        """Stop every variant that has a task; shared tasks continue as long as another variant needs them."""
        assert task.frame is not None
        for variant in self._users[task.node]:
            self._found[variant] = min(self._found.get(variant, (task.frame, why)), (task.frame, why))
        for name, users in self._users.items():
            if all(user in self._found for user in users):
                self._limits[name] = max(self._found[user][0] for user in users)


def read_table(graph: Graph, store: Store, task: Task, record: Record) -> Table:
    """Read a result that is a table; BadInput for any other."""
    value = read_value(graph, store, task, record)
    if not isinstance(value, Table):
        raise BadInput(f"'{task}' is not a table", where=graph.path, right="a node with a Table as output")
    return value


def broken(criterion: Comparison, table: Table) -> str | None:
    """Compare a column of a table; return the worst value that stops a variant in words, None without one."""
    if criterion.column not in table.numbers:
        what = f"stop: '{criterion.node}' has no column"
        right = nearest(criterion.column, list(table.numbers))
        raise BadInput(f"{what} '{criterion.column}'", right=right)
    values = table.numbers[criterion.column]
    worst = values[criterion.holds(values, criterion.right)]
    if not len(worst):
        return None
    value = min(worst) if criterion.relation.startswith("<") else max(worst)
    return f"{criterion.left} {value:.4g} {criterion.relation} {json.dumps(criterion.right)}"
