"""Keys of tasks: all that a result depends on, part by part, the results by key, and the differences of two keys.

type      name of the node type
code      digest of its module with all imports, of versions, and of the class of the processor: `hairpipe.engine.code`
settings  checked values; a file is there by its bytes and suffix, a choice that calls libraries with their versions
inputs    by socket, or `socket.0` ...: a digest, [previous, current], [[frame, digest], ...] or None
time      frame, fps, cuts, first frame and origin of the result where the node asks for them, else None
"""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeGuard

from hairpipe.engine.code import Code, CodeReader, version
from hairpipe.engine.file.graph import Edge, Graph, Node, base_name
from hairpipe.engine.file.read import Location
from hairpipe.engine.node.declare import Cuts, First, Origin, Time
from hairpipe.engine.node.settings import Field, fields_of, map_values
from hairpipe.engine.plan.arguments import name_inputs
from hairpipe.engine.plan.tasks import Inputs, Source, Task, sources, unroll
from hairpipe.engine.store.digest import Parts, digest
from hairpipe.engine.store.fingerprint import fingerprint
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Record, Store
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

TIMES = {Time: ("frame", "fps"), Cuts: ("cuts",), First: ("first",), Origin: ("origin",)}
"""Parts of the time in a key, by the type of the parameter that asks for them."""


def keyed_settings(graph: Graph, node: Node, store: Store, files: dict[str, str]) -> dict[str, Any]:
    """Return the settings of a node as part of a key; BadInput for a file that cannot be read.

    files  digests by path: those of the files of the settings are added
    """

    def as_key(field: Field, setting: str, value: Any) -> Any:
        if field.base is not Path:
            libraries = field.libraries(value)
            return {"choice": value, "versions": {name: version(name) for name in libraries}} if libraries else value
        contents = {name: content_of(path) for name, path in graph.read(node, setting, value).items()}
        return contents.get("", contents)

    def content_of(path: Path) -> dict[str, str]:
        check_plain(path, "a file")
        try:
            content = files[str(path)] = fingerprint(path, store)
        except OSError as error:
            where = Location(f"[{node.name}]", node.name)
            raise BadInput(f"{path} cannot be read: {error.strerror}", where=where) from None
        return {"file": content, "suffix": path.suffix.lower()}

    return map_values(fields_of(node.type), node.settings, as_key)


def origin_of(graph: Graph, node: str, settings: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the fields of the `Origin` of a node as plain values.

    settings  of all nodes, as in their keys
    """
    plain = {name: without_versions(values) for name, values in settings.items()}

    @cache
    def key(name: str) -> str:
        own = graph.nodes[name]
        inputs = {plug: [key(edge.node), edge.output] for plug, edge in own.edges.items()}
        return digest("origin", {"type": own.type.name, "settings": plain[name], "in": inputs})

    nodes = {}
    for name, own in graph.upto([node]).nodes.items():
        sources = {plug: ".".join(filter(None, (base_name(e.node), e.output))) for plug, e in own.edges.items()}
        nodes[base_name(name)] = {"type": own.type.name, "in": sources, "settings": plain[name]}
    shot = {"fps": graph.fps, "first": graph.frames[0], "preroll": graph.preroll, "cuts": list(graph.cuts)}
    return {"node": base_name(node), "key": key(node), "shot": shot, "nodes": nodes}


def without_versions(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a key with choices alone, without the versions of the libraries that they call."""
    found = {}
    for name, value in settings.items():
        if isinstance(value, dict):
            is_choice = value.keys() == {"choice", "versions"}
            found[name] = value["choice"] if is_choice else without_versions(value)
        else:
            found[name] = value
    return found


def differing_versions(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return the versions in the settings of a key, by library, that are not those of this machine."""
    found = {}
    for value in settings.values():
        if isinstance(value, dict) and value.keys() == {"choice", "versions"}:
            found |= {name: other for name, other in value["versions"].items() if version(name) != other}
        elif isinstance(value, dict):
            found |= differing_versions(value)
    return found


def differences(old: Parts, new: Parts, modules: dict[str, str], store: Store) -> Iterator[str]:
    """Describe the differences, in the order type, settings, inputs, time, code.

    modules  of the new digest of code; those of the old digest are in the store
    """
    if old["type"] != new["type"]:
        yield f"type {old['type']} -> {new['type']}"
        return
    yield from setting_differences(old["settings"], new["settings"], "setting ")
    yield from input_differences(old["inputs"], new["inputs"])
    yield from setting_differences(old["time"] or {}, new["time"] or {}, "")
    if old["code"] != new["code"]:
        yield from code_differences(json.loads(store.recall(old["code"]) or "{}"), modules)


def setting_differences(old: dict[str, Any], new: dict[str, Any], label: str) -> Iterator[str]:
    """Compare settings by name, groups field by field, files by their bytes."""
    for name in sorted(old.keys() | new.keys()):
        before = old.get(name)
        after = new.get(name)
        if json.dumps(before) == json.dumps(after):
            continue
        if is_file(before) and is_file(after):
            yield f"contents of the file of {label}{name}"
        elif is_group(before) and is_group(after):
            yield from setting_differences(before, after, f"{label}{name}.")
        else:
            yield f"{label}{name} {formatted(before)} -> {formatted(after)}"


def input_differences(old: dict[str, Any], new: dict[str, Any]) -> Iterator[str]:
    """Compare the inputs of each socket; of several frames, list those that differ."""
    for name in sorted(old.keys() | new.keys()):
        before = old.get(name)
        after = new.get(name)
        if before == after:
            continue
        if before is None or after is None:
            yield f"input {name} {'connected' if before is None else 'disconnected'}"
        elif all(isinstance(value, list) and isinstance(value[0], list) for value in (before, after)):
            known, now = dict(before), dict(after)
            frames = f"frames {min(known)}-{max(known)} -> {min(now)}-{max(now)}"
            if known.keys() == now.keys():
                first, *others = [frame for frame in now if known[frame] != now[frame]]
                frames = f"at frame {first}" + (f" and {len(others)} more" if others else "")
            yield f"input {name} {frames}"
        else:
            yield f"input {name}"


def code_differences(old: dict[str, str], new: dict[str, str]) -> Iterator[str]:
    """List differing modules, versions and class of processor; "code" if the old ones are unknown."""
    if not old:
        yield "code"
        return
    for name in sorted(old.keys() | new.keys()):
        if old.get(name) == new.get(name):
            continue
        what, _, kind = name.removesuffix(")").partition(" (")
        if kind:
            yield f"{kind} of {what} {old.get(name, 'unknown')} -> {new.get(name, 'unknown')}"
        else:
            yield f"code {name}" + (" (new)" if name not in old else " (no longer used)" if name not in new else "")


def is_file(value: Any) -> bool:
    return isinstance(value, dict) and value.keys() == {"file", "suffix"}


def is_group(value: Any) -> TypeGuard[dict[str, Any]]:
    return isinstance(value, dict) and not is_file(value)


def formatted(value: Any) -> str:
    """Return a setting as in a graph file; a description of an absent value, a group or a file."""
    if value is None:
        return "absent"
    return "a file" if is_file(value) else "a group" if is_group(value) else json.dumps(value)


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
        self.origins = {n.name: origin_of(graph, n.name, self.settings) for n in nodes if n.type.asks(Origin)}

    def parts(self, task: Task) -> Parts:
        """Return the parts of the key of a task, whose inputs must be known."""
        node = self.graph.nodes[task.node]
        time = self.time_of(task)
        asked = [name for kind, names in TIMES.items() if node.type.asks(kind) for name in names]
        return {
            "type": node.type.name,
            "code": self.codes[node.name].digest,
            "settings": self.settings[node.name],
            "inputs": name_inputs(node.type, self.tasks[task], self.frames, self.object, self.key),
            "time": {name: time[name] for name in asked if time[name] != []} or None,
        }

    def object(self, source: Source) -> str:
        return self.results[source.task].outputs[source.output].object

    def key(self, source: Source) -> str:
        return self.results[source.task].key

    def time_of(self, task: Task) -> dict[str, Any]:
        """Return frame (for a value for the shot, the first of the run), frames per second, cuts, first frame, origin.

        The origin is None where the node does not ask for one.
        """
        frame = self.frames[0] if task.frame is None else task.frame
        cuts = self.graph.cuts_of(self.graph.nodes[task.node], task.frame, self.frames)
        time = {"frame": frame, "fps": self.graph.fps, "cuts": list(cuts), "first": self.graph.frames[0]}
        return time | {"origin": self.origins.get(task.node)}

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
