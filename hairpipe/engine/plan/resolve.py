"""Keys and records of tasks, for plans and runs.

Divergence of scans: nodes with `Reached` inputs continue with the frames before.
"""

from typing import Any, NamedTuple

from hairpipe.engine.code import Code, CodeReader
from hairpipe.engine.file.graph import Edge, Graph, Node
from hairpipe.engine.plan.arguments import name_inputs
from hairpipe.engine.plan.key import keyed_settings, keyed_time
from hairpipe.engine.plan.tasks import Inputs, Source, Task, sources, unroll
from hairpipe.engine.store.digest import Parts, digest
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.record import Record
from hairpipe.engine.store.store import Store


class Resolver:
    """Inputs of every task, its key when the results of these are known, and its own result.

    frames   requested frames; scans need earlier ones, too
    results  known results by task
    reader   of the code of the nodes
    files    digests of input files by absolute path, by node
    """

    def __init__(self, graph: Graph, store: Store, frames: tuple[int, ...]) -> None:
        self.graph = graph
        self.store = store
        self.leases = Leases(store)
        self.frames = frames
        self.tasks: dict[Task, Inputs] = unroll(graph, frames)
        self.results: dict[Task, Record] = {}
        self.demanded: set[Task] = set()
        self.reader = CodeReader(store.remember, graph.folder)
        self.codes = self._read_codes()
        self.files: dict[str, dict[str, str]] = {name: {} for name in graph.nodes}
        nodes = graph.nodes.values()
        self.settings = {node.name: keyed_settings(graph, node, store, self.files[node.name]) for node in nodes}

    def parts(self, task: Task) -> Parts:
        """Return the parts of the key of a task, whose inputs must be known."""
        node = self.graph.nodes[task.node]
        return {
            "type": node.type.name,
            "code": self.codes[node.name].digest,
            "settings": self.settings[node.name],
            "inputs": name_inputs(node.type, self.tasks[task], self.frames, self.object, self.key),
            "time": keyed_time(node, self.time_of(task)),
        }

    def object(self, source: Source) -> str:
        """Return the name of the object of a source."""
        return self.results[source.task].outputs[source.output].object

    def key(self, source: Source) -> str:
        """Return the key of the result of a source."""
        return self.results[source.task].key

    def time_of(self, task: Task) -> dict[str, Any]:
        """Return the frame of a task, for the shot the first of the run, frames per second, cuts, and the first frame."""
        frame = self.frames[0] if task.frame is None else task.frame
        cuts = self.graph.cuts_of(self.graph.nodes[task.node], task.frame, self.frames)
        return {"frame": frame, "fps": self.graph.fps, "cuts": list(cuts), "first": self.graph.frames[0]}

    def find(self, task: Task, key: str) -> Record | None:
        """Find the result of a task in the store; the state of a scan may be missing unless it is demanded."""
        node = self.graph.nodes[task.node]
        record = self.store.find(key, without=None if task in self.demanded else state_of(node))
        return record if record is None or record.outputs.keys() == node.type.outputs.keys() else None

    def thinnable(self, node: Node) -> str | None:
        """Return the removable output of a scan, an input of its next frame alone; None if a node takes it."""
        state = state_of(node)
        return None if state is None or Edge(node.name, state) in self.graph.taken else state

    def missing(self, task: Task) -> set[Task]:
        """Return the tasks whose objects a task needs and which neither the store nor a worker has."""
        gone = set()
        for source in sources(self.tasks[task]):
            output = self.results[source.task].outputs[source.output]
            is_stored = all(self.store.has(*pair) for pair in ((output.object, output.size), *output.parts))
            if not is_stored and not self.leases.is_in_memory(output.object):
                gone.add(source.task)
        return gone

    def _read_codes(self) -> dict[str, Code]:
        nodes = self.graph.nodes.values()
        codes = {module: self.reader.code_of(module) for module in dict.fromkeys(node.type.module for node in nodes)}
        for code in codes.values():
            self.store.remember(code.digest, lambda found=code: found.manifest)
        return {node.name: codes[node.type.module] for node in nodes}


def state_of(node: Node) -> str | None:
    """Return the output of a scan that is an input of its next frame, if it has another output, too."""
    return node.type.state if len(node.type.outputs) > 1 else None


class Divergence(NamedTuple):
    """A scan that diverged.

    lost       tasks of the scan, from the failed one on
    consumers  tasks of other nodes that continue with the frames before
    """

    lost: frozenset[Task]
    consumers: frozenset[Task]


def divergence_note(key: str) -> str:
    """Return the name of the note in the store on divergence of the task with this key; plans read it."""
    return digest("ending", key)


def end_known_scan(resolver: Resolver, task: Task, key: str) -> Divergence | None:
    """End a scan, as `end_scan`, if the store has a note on divergence of the task with this key."""
    return None if resolver.store.recall(divergence_note(key)) is None else end_scan(resolver, task)


def end_scan(resolver: Resolver, failed: Task) -> Divergence | None:
    """Remove the tasks of a scan, from a failed one on, from `Reached` inputs; in place.

    Returns None without a change if another node needs all frames, no node needs any, or no frame was reached.
    """
    node = resolver.graph.nodes[failed.node]
    if node.type.mode != "scan" or node.publish is not None or failed.frame is None:
        return None
    tasks = [task for task in resolver.tasks if task.node == failed.node]
    lost = frozenset(task for task in tasks if task.frame is not None and task.frame >= failed.frame)
    left = {}
    for task, inputs in resolver.tasks.items():
        socket = resolver.graph.nodes[task.node].type.socket
        for plug, found in inputs.items():
            if task.node == failed.node or not any(source.task in lost for source in found):
                continue
            left[task, plug] = [source for source in found if source.task not in lost]
            if socket(plug).view != "reached" or not left[task, plug]:
                return None
    for (task, plug), found in left.items():
        resolver.tasks[task][plug] = found
    return Divergence(lost, frozenset(task for task, _ in left)) if left else None
