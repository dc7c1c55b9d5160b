"""Keys and records of tasks, for plans and runs."""

from typing import Any

from hairpipe.engine.code import Code, CodeReader
from hairpipe.engine.file.graph import Edge, Graph, Node
from hairpipe.engine.plan.arguments import name_inputs
from hairpipe.engine.plan.key import keyed_settings, keyed_time
from hairpipe.engine.plan.tasks import Inputs, Source, Task, sources, unroll
from hairpipe.engine.store.digest import Parts
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
        """Return frame (for a value for the shot, the first of the run), frames per second, cuts, and first frame."""
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
