"""Builds a graph from tables; all names, types of edges, frames and settings are checked.

`like`: a node that copies another node and lists only the differences.
`mute = true`: a node that is passed by, as if its input of the same type were its output.
"""

import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any

from hairpipe.engine.file.bounds import RIGHT, is_data, located
from hairpipe.engine.file.graph import FRAME_MARK, Edge, Graph, Node, project_of
from hairpipe.engine.file.overrides import LAYOUT, nodes_of, parse_value, put
from hairpipe.engine.file.read import ESCAPE, MOST_FRAMES, GraphText, read_graph_text
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.file.trust import Untrusted
from hairpipe.engine.file.wedge import read_wedges
from hairpipe.engine.node.declare import RESERVED, SINGLE, File, NodeType, Socket, Spent
from hairpipe.engine.node.messages import brief, closest, listed, nearest
from hairpipe.engine.node.settings import SHORTHAND, Missing, check_settings, field_at, fields_of, map_files
from hairpipe.errors import BadInput
from hairpipe.plain_file import special

Place = Callable[[Sequence[str]], str]
MOST_SOURCES = 4
"""Maximum number of nodes that a message suggests."""


def read_edges(given: Any, node_type: NodeType, place: Place) -> dict[str, Edge]:
    """Read the table `in`: socket to "node" or "node.output", or to a list of those where the socket takes many."""
    if not isinstance(given, dict):
        raise BadInput(f"in = {brief(given)} is not a table", where=place(["in"]), right='in.body = "node"')
    edges = {}
    for name, value in given.items():
        where = place(["in", name])
        if name not in node_type.sockets:
            right = suggest_socket(name, node_type.sockets.values())
            raise BadInput(f"no socket '{name[:60]}'", where=where, right=right)
        socket = node_type.sockets[name]
        sources = value if socket.many and isinstance(value, list) else [value]
        if not sources or not all(isinstance(source, str) for source in sources):
            right = '"node" or "node.output"' + (", or a list of those" if socket.many else ", one edge")
            raise BadInput(f"in.{name} = {brief(value)}", where=where, right=right)
        plugs = [f"{name}.{number}" for number in range(len(sources))] if socket.many else [name]
        edges |= {plug: Edge(*source.partition(".")[::2]) for plug, source in zip(plugs, sources, strict=True)}
    return edges


def suggest_socket(name: str, sockets: Collection[Socket]) -> str:
    """Suggest the socket closest to an unknown name, or the sockets of a type of that name; list all sockets."""
    types = {socket.name: socket.type.__name__ for socket in sockets}
    plain = name.lower().replace("_", "")
    near = [socket for socket, kind in types.items() if kind.lower() == plain] or [closest(name, list(types))]
    hint = " or ".join(f"'{socket}'" for socket in near if socket)
    listing = listed([f"{socket} ({kind})" for socket, kind in types.items()])
    return (f"did you mean {hint}? " if hint else "") + (f"sockets: {listing}" if types else "there are none")


class Incomplete(BadInput):
    """A node has no value for a required input or setting.

    node  name of the node
    """

    def __init__(self, node: str, what: str, where: object, right: str | None) -> None:
        super().__init__(what, where=where, right=right)
        self.node = node


def connect(nodes: dict[str, Node], place: Callable[[str, list[str], str], str], registry: Registry) -> dict[str, Node]:
    """Check the types of all edges, and add the names of omitted outputs."""
    connected = {}
    for node in nodes.values():
        plugged = {plug.partition(".")[0] for plug in node.edges}
        for socket in node.type.sockets.values():
            if not socket.optional and socket.name not in plugged:
                what = f"socket '{socket.name}' is not connected, it takes {socket.type.__name__}"
                where = place(node.name, ["in"], node.type.name)
                right = suggest_source(socket, node, nodes, registry)
                raise Incomplete(node.name, what, where, f"in.{socket.name} = {right}")
        edges = {}
        for plug, edge in node.edges.items():
            where = place(node.name, ["in", node.type.socket(plug).name], node.type.name)
            if edge.node not in nodes:
                right = nearest(edge.node, list(nodes))
                raise BadInput(f"in.{plug}: no node '{edge.node[:60]}'", where=where, right=right)
            try:
                edges[plug] = check_edge(node, plug, edge, nodes[edge.node], where)
            except WrongType as fault:
                right = suggest_source(node.type.socket(plug), node, nodes, registry)
                raise BadInput(fault.what, where=where, right=right) from None
        connected[node.name] = replace(node, edges=edges)
    return connected


class WrongType(BadInput):
    """The type of the output differs from that of the socket."""


def suggest_source(socket: Socket, node: Node, nodes: dict[str, Node], registry: Registry) -> str:
    """Suggest nodes with an output of the type of a socket; if there are none, node types."""
    kind = socket.type.__name__
    edges = []
    for other in nodes.values():
        outputs = [name for name, given in other.type.outputs.items() if given is socket.type and other is not node]
        edges += [f'"{other.name}"' if len(outputs) == 1 else f'"{other.name}.{name}"' for name in outputs]
    if edges:
        return f"{' or '.join(edges[:MOST_SOURCES])}, which gives {kind}"
    return f"a node that gives {kind}: {listed(registry.types_with_output(socket.type)) or 'no type does'}"


def check_edge(node: Node, plug: str, edge: Edge, source: Node, where: str) -> Edge:
    """Check output, type and frames of one edge; the output may be omitted if only one has the type.

    Types are compared for equality: a value contains exactly the fields of its type, so derived types differ.
    """
    socket = node.type.socket(plug)
    if socket.type is Spent:
        return check_spent(plug, edge, source, where)
    fitting = [output for output, kind in source.type.outputs.items() if kind is socket.type]
    if edge.output and edge.output not in source.type.outputs:
        named = [output for output in source.type.outputs if output != SINGLE]
        right = nearest(edge.output, named) if named else f'"{source.name}", it has one output without a name'
        raise BadInput(f"in.{plug}: '{source.name}' has no output '{edge.output[:60]}'", where=where, right=right)
    if not fitting or (edge.output and edge.output not in fitting):
        given = source.type.outputs.get(edge.output)
        what = given.__name__ if given else ", ".join(kind.__name__ for kind in source.type.outputs.values())
        raise WrongType(f"in.{plug} takes {socket.type.__name__}, '{source.name}' gives {what}")
    if not edge.output and len(fitting) > 1:
        right = "one of " + ", ".join(f'"{source.name}.{output}"' for output in fitting)
        raise BadInput(f"in.{plug}: several outputs of '{source.name}' fit", where=where, right=right)
    if source.per_frame and not node.per_frame and socket.view not in ("frames", "reached"):
        what = f"in.{plug}: '{source.name}' gives a value per frame, '{node.name}' takes one for the shot"
        kind = socket.type.__name__
        right = f"a node that gives one {kind} for the shot, or a type that takes Frames[{kind}]"
        raise BadInput(what, where=where, right=right)
    if source.per_frame and node.type.prepare and socket.name in node.type.prepare.sockets:
        what = f"in.{plug}: '{source.name}' gives a value per frame, '{node.name}' is prepared with it for all frames"
        raise BadInput(what, where=where, right=f"a node that gives one {socket.type.__name__} for the shot")
    return Edge(source.name, edge.output or fitting[0])


def check_spent(plug: str, edge: Edge, source: Node, where: str) -> Edge:
    """Check an edge of the computation time of results, of a node with one result per frame and any output."""
    if edge.output:
        what = f"in.{plug} takes the time of a node, '{edge.output[:60]}' is one of its outputs"
        raise BadInput(what, where=where, right=f'"{source.name}"')
    if not source.per_frame:
        what = f"in.{plug} takes the time of each frame, '{source.name}' has one value for the shot"
        raise BadInput(what, where=where, right="a node with a value per frame")
    outputs = source.type.outputs
    return Edge(source.name, next(name for name in outputs if name != source.type.state or len(outputs) == 1))


OWN = frozenset({"like", "without", "publish", "checkpoint", "mute"})
"""Keys without effect on results, which are never copied."""

Table = dict[str, Any]


def written_out(text: GraphText) -> GraphText:
    """Return a graph file with every `like` expanded; BadInput as for `write_out`."""
    return text.edited(text.tables | write_out(text, nodes_of(text.tables)))


def write_out(text: GraphText, tables: dict[str, Table]) -> dict[str, Table]:
    """Return tables with every `like` expanded; pure.

    A node copies type, edges and settings of its base, recursively through groups, and lists the differences.
    `without` lists omitted parts of the base, such as "stiction" or "in.surface"; an omitted group that is also listed
    starts empty. A plain value replaces a group; a group that replaces a plain value starts with it. Bases are
    expanded first. BadInput for an unknown base, a cycle of bases, or a part to omit that the base does not have.
    """
    bases = {name: [base_of(text, name, tables)] if "like" in table else [] for name, table in tables.items()}
    try:
        order = list(TopologicalSorter(bases).static_order())
    except CycleError as error:
        circle = error.args[1]
        where = text.place(circle[-1], ["like"])
        right = "one of them without `like`"
        raise BadInput(f"circular `like`: {' -> '.join(reversed(circle))}", where=where, right=right) from None
    written: dict[str, Table] = {}
    for name in order:
        if not bases[name] and "without" in tables[name]:
            where = text.place(name, ["without"])
            right = 'like = "node"'
            raise BadInput("without, in a node that has no `like`", where=where, right=right)
        base = {key: value for base in bases[name] for key, value in written[base].items() if key not in OWN}
        try:
            for dotted in left_out(text, name, tables[name], base):
                base = without(base, dotted.split("."))
            own = {key: value for key, value in tables[name].items() if key not in ("like", "without")}
            written[name] = merged(base, own)
        except RecursionError:  # a dotted key of a thousand names
            raise BadInput("nested too deeply", where=text.place(name)) from None
    return written


def base_of(text: GraphText, name: str, tables: dict[str, Table]) -> str:
    base = tables[name]["like"]
    where = text.place(name, ["like"])
    if not isinstance(base, str):
        raise BadInput(f"like = {brief(base)} is not the name of a node", where=where, right='like = "node"')
    if base not in tables:
        right = nearest(base, [other for other in tables if other != name])
        raise BadInput(f"like: no node '{base[:60]}'", where=where, right=right)
    return base


def left_out(text: GraphText, name: str, table: Table, base: Table) -> Sequence[str]:
    """Read the dotted names of omitted parts; BadInput for one that the base does not have."""
    given = table.get("without", [])
    where = text.place(name, ["without"])
    if not isinstance(given, list) or not all(isinstance(dotted, str) for dotted in given):
        raise BadInput(f"without = {brief(given)}", where=where, right='a list of names, as ["stiction", "in.body"]')
    known = list(dotted_names(base))
    for dotted in given:
        if dotted not in known:
            what = f"without: '{table['like']}' has no '{dotted[:60]}'"
            raise BadInput(what, where=where, right=nearest(dotted, known))
    return given


def dotted_names(table: Table, prefix: str = "") -> Iterator[str]:
    """List the names in a table, with those in groups as `group.name`."""
    for name, value in table.items():
        yield prefix + name
        if isinstance(value, dict):
            yield from dotted_names(value, f"{prefix}{name}.")


def without(table: Table, names: Sequence[str]) -> Table:
    """Return a table without a dotted name; unchanged if the name is absent."""
    first, *rest = names
    if not rest or not isinstance(table.get(first), dict):
        return {name: value for name, value in table.items() if name != first}
    return {**table, first: without(table[first], rest)}


def merged(base: Table, own: Table) -> Table:
    """Return a table with another merged into it, recursively through groups."""
    result = dict(base)
    for name, value in own.items():
        if isinstance(value, dict) and name in base:
            group = {} if base[name] is False else base[name]
            value = merged(group if isinstance(group, dict) else {SHORTHAND: group}, value)
        result[name] = value
    return result


def muted_nodes(text: GraphText, tables: Mapping[str, dict[str, object]]) -> set[str]:
    """Return the names of muted nodes; BadInput for a value other than true and false."""
    for name, table in tables.items():
        if not isinstance(table.get("mute", False), bool):
            raise BadInput(f"mute of '{name}'", where=text.place(name, ["mute"]), right="true or false")
    return {name for name, table in tables.items() if table.get("mute")}


def passed_by(nodes: Mapping[str, Node], muted: set[str]) -> dict[str, Node]:
    """Return the other nodes: an edge from a muted node begins where its first input of the same type does.

    An optional input of a type that the muted node does not take is not connected then; pure.
    """
    kept = {}
    for node in nodes.values():
        if node.name not in muted:
            edges = {plug: resolved(node, plug, edge, nodes, muted) for plug, edge in node.edges.items()}
            kept[node.name] = replace(node, edges={plug: edge for plug, edge in edges.items() if edge is not None})
    return kept


def resolved(node: Node, plug: str, edge: Edge, nodes: Mapping[str, Node], muted: set[str]) -> Edge | None:
    kind = node.type.socket(plug).type
    seen = set[str]()
    while edge.node in muted and edge.node not in seen:
        seen.add(edge.node)
        source = nodes[edge.node]
        fitting = [found for name, found in source.edges.items() if source.type.socket(name).type is kind]
        if not fitting:
            return None
        edge = fitting[0]
    return edge


SCHEMA = 1
KEYS = ("schema", "frames", "fps", "preroll", "cuts")
MOST_LETTERS = 100
NAME = f"a letter, then letters, digits, - and _, at most {MOST_LETTERS} in all"
SHORT_ESCAPE = re.compile(r"[\b\t\n\f\r]")
DRIVE = re.compile(r"[A-Za-z]:[\\/]|\\\\")
CHECKPOINT = 24
"""Default interval of checkpoints: a resumed simulation recomputes at most this many frames."""


def load_graph(path: Path, overrides: Mapping[str, str] | None = None) -> Graph:
    """Read and check a graph file; BadInput with file and line for the first error.

    overrides  settings by `node.setting`, or `node.group.setting`, as text: TOML if it parses, else a string
    """
    text = read_graph_text(path)
    for target, value in (overrides or {}).items():
        put(text.tables, target, parse_value(value))
    return make_graph(text)


def make_graph(text: GraphText, *, empty: bool = False) -> Graph:
    """Check the tables of a graph file, which may have been edited after reading; BadInput as above.

    empty  whether a graph without nodes is accepted

    Incomplete, which is a BadInput, for a node without a required input or setting, if no table has another fault.
    """
    path = text.path
    tables = nodes_of(text.tables)
    check_header(text)
    check_layout(text)
    read_wedges(text)
    registry = Registry(path.parent / "nodes")
    written = write_out(text, tables)
    nodes = dict[str, Node]()
    missing = list[Incomplete]()
    for name, table in written.items():
        try:
            nodes[name] = read_node(text, name, table, registry)
        except Incomplete as fault:
            missing.append(fault)
    if missing:
        raise missing[0]
    nodes = {name: nodes[name] for name in tables}
    if not nodes and not empty:
        raise BadInput("no nodes", where=path, right='a table such as [head] with type = "make_bust"')
    nodes = connect(passed_by(nodes, muted_nodes(text, written)), text.place, registry)
    frames = read_frames(text)
    taken = frozenset(edge for node in nodes.values() for edge in node.edges.values())
    ordered = {name: nodes[name] for name in sort_nodes(nodes, path)}
    preroll = read_preroll(text)
    cuts = read_cuts(text)
    graph = Graph(path, project_of(path), frames, read_fps(text), ordered, taken, preroll, cuts)
    check_publish(graph, text)
    return graph


def check_header(text: GraphText) -> None:
    """Check the top-level keys of a graph file, `schema` first."""
    schema = text.tables.get("schema")
    if schema != SCHEMA or isinstance(schema, bool):
        what = "no schema" if schema is None else f"schema = {brief(schema)} is unknown"
        raise BadInput(what, where=text.place(None, ["schema"]), right=f"schema = {SCHEMA}")
    for key, value in text.tables.items():
        if key not in KEYS and not isinstance(value, dict):
            right = f"{nearest(key, KEYS)}; a node is a table [{key}]"
            raise BadInput(f"unknown key '{key}'", where=text.place(None, [key]), right=right)


def check_layout(text: GraphText) -> None:
    for name, value in text.tables.get(LAYOUT, {}).items():
        if not is_layout(value):
            right = "[x, y], { title = TEXT, nodes = [...] } or { text = TEXT, at = [x, y] }; no node is called layout"
            raise BadInput(f"{LAYOUT}.{name} = {brief(value)}", where=text.place(LAYOUT, [name]), right=right)


def is_layout(value: Any) -> bool:
    """Whether a value is a position, a frame or a note."""
    match value:
        case [x, y]:
            return type(x) in (int, float) and type(y) in (int, float)
        case {"title": str(), "nodes": [*nodes], **others}:
            return not others and all(isinstance(node, str) for node in nodes)
        case {"text": str(), "at": [_, _] as at, **others}:
            return not others and is_layout(at)
    return False


def read_frames(text: GraphText) -> tuple[int, int]:
    frames = text.tables.get("frames")
    right = f"frames = [first, last], whole numbers, first <= last, at most {MOST_FRAMES}"
    place = text.place(None, ["frames"])
    if not isinstance(frames, list) or len(frames) != 2 or any(type(f) is not int for f in frames):
        what = "no frames" if frames is None else f"frames = {brief(frames)} is not a range"
        raise BadInput(what, where=place, right=right)
    first, last = frames
    if not 0 <= last - first < MOST_FRAMES or abs(first) > 10**9:
        raise BadInput(f"frames = {brief(frames)} is not a range", where=place, right=right)
    return first, last


def read_fps(text: GraphText) -> float:
    fps = text.tables.get("fps")
    if not isinstance(fps, (int, float)) or isinstance(fps, bool) or not 0.01 <= fps <= 100_000:
        what = "no fps" if fps is None else f"fps = {brief(fps)} is not a frame rate"
        raise BadInput(what, where=text.place(None, ["fps"]), right="fps = 24; a number in 1/s, 0.01 to 100000")
    return float(fps)


def read_preroll(text: GraphText) -> int:
    """Read `preroll`, the number of frames of scans before the first; 0 if absent."""
    preroll = text.tables.get("preroll", 0)
    if type(preroll) is not int or not 0 <= preroll < MOST_FRAMES:
        what = f"preroll = {brief(preroll)} is not a number of frames"
        right = "preroll = 24; a whole number, not negative"
        raise BadInput(what, where=text.place(None, ["preroll"]), right=right)
    return preroll


def read_cuts(text: GraphText) -> tuple[int, ...]:
    """Read `cuts`, the frames at which the shot is cut; none if absent."""
    cuts = text.tables.get("cuts", [])
    if not isinstance(cuts, list) or any(type(cut) is not int for cut in cuts) or cuts != sorted(set(cuts)):
        right = "cuts = [1013, 1047]: frame numbers, ascending; each is the first frame after a cut"
        raise BadInput(f"cuts = {brief(cuts)}", where=text.place(None, ["cuts"]), right=right)
    return tuple(cuts)


def read_node(text: GraphText, name: str, table: dict[str, Any], registry: Registry) -> Node:
    plain = name.isascii() and name.replace("-", "").replace("_", "").isalnum()
    if not plain or not name[:1].isalpha() or len(name) > MOST_LETTERS:
        raise BadInput(f"'{name[:60]}' is not the name of a node", where=text.place(name), right=NAME)
    type_name = table.get("type")
    if not isinstance(type_name, str):
        what = "no type" if type_name is None else f"type = {brief(type_name)} is not a text"
        raise BadInput(what, where=text.place(name, ["type"]), right='type = "...", see `hairpipe nodes`')
    try:
        node_type = registry.find(type_name)
    except Untrusted:
        raise
    except BadInput as error:
        raise BadInput(error.what, where=text.place(name, ["type"]), right=error.right) from error

    def place(names: Sequence[str]) -> str:
        return text.place(name, names, type_name)

    edges = read_edges(table.get("in", {}), node_type, place)
    given = {key: value for key, value in table.items() if key not in RESERVED}
    given = located(fields_of(node_type), given, place)
    for key in sorted(given.keys() & set(KEYS) - {field.name for field in fields_of(node_type)}):
        right = f"{key} above all tables, for the whole graph"
        raise BadInput(f"unknown setting '{key}'", where=place([key]), right=right)
    try:
        settings = check_settings(node_type, given, place)
    except Missing as fault:
        raise Incomplete(name, fault.what, fault.where, fault.right) from None
    map_files(fields_of(node_type), settings, lambda dotted, file: check_file(text, name, node_type, dotted, file))
    publish = read_publish(table.get("publish"), text.path.parent, node_type, place(["publish"]))
    checkpoint = read_checkpoint(table, node_type, place(["checkpoint"]))
    return Node(name, node_type, edges, settings, publish, checkpoint)


def check_file(text: GraphText, node: str, node_type: NodeType, dotted: str, file: str) -> None:
    """Check that the file of a setting exists and has a supported format."""
    path = text.path.parent / file
    names = dotted.split(".")
    field = field_at(node_type, names)
    right = RIGHT if is_data(file) else f"a file, relative to {text.path.parent}"
    if field is not None and field.reads and field.reads.mark in path.name:
        try:
            path = next(iter(field.reads.files(path).values()))
        except BadInput as error:
            raise BadInput(error.what, where=text.place(node, names), right=error.right) from None
    try:
        fault = None if path.is_file() else "is a folder" if path.is_dir() else "does not exist"
        if kind := special(path):
            fault = f"is {kind}"
    except (OSError, ValueError) as error:
        fault = f"cannot be a file: {error}"
    if field is not None and field.suffixes and path.suffix.lower() not in field.suffixes:
        fault = f"is not a file that {node_type.name} reads"
        right = field.allowed
    if fault:
        fault, right = explain_windows(file) or (fault, right)
        raise BadInput(f"{dotted} = {file[:200]!r} {fault}", where=text.place(node, names), right=right)


def explain_windows(file: str) -> tuple[str, str] | None:
    """Return what is wrong with a path that is written as on Windows, and what would be right; None for any other."""
    if SHORT_ESCAPE.search(file):
        return "has a control character", ESCAPE
    if DRIVE.match(file):
        return "is on a drive of Windows", "a path on this machine, with /"
    return ("does not exist: / separates folders", repr(file.replace("\\", "/"))) if "\\" in file else None


def read_publish(publish: Any, folder: Path, node_type: NodeType, where: str) -> Path | None:
    """Read the path of the published file of a node."""
    if publish is None:
        return None
    if list(node_type.outputs.values()).count(File) != 1:
        raise BadInput(f"{node_type.name} has no file to publish", where=where, right="a node whose output is a File")
    if not isinstance(publish, str) or not publish.strip("/.") or "\0" in publish or publish.endswith("/"):
        raise BadInput(f"publish = {brief(publish)} is not a path", where=where, right='"../out/shot.####.usd"')
    if fault := explain_windows(publish):
        raise BadInput(f"publish = {publish!r} {fault[0]}", where=where, right=fault[1])
    path = (folder / publish).resolve()
    marks = len(FRAME_MARK.findall(path.name))
    if "#" in str(Path(publish).parent) or marks > 1:
        raise BadInput(f"publish = {publish!r}: frames go in one place of the file name", where=where, right="####.png")
    if marks != (node_type.mode != "once"):
        right = '"picture.####.png", #### is the frame' if not marks else "no ####: the node gives one file"
        raise BadInput(f"publish = {publish!r} does not fit {node_type.name}", where=where, right=right)
    return path


def read_checkpoint(table: dict[str, Any], node_type: NodeType, where: str) -> int:
    checkpoint = table.get("checkpoint", CHECKPOINT)
    if node_type.mode != "scan" and "checkpoint" in table:
        raise BadInput(f"{node_type.name} keeps no state", where=where, right="checkpoint belongs to a scan")
    if type(checkpoint) is not int or checkpoint < 1:
        right = "a whole number >= 1: every n-th frame's state is kept"
        raise BadInput(f"checkpoint = {brief(checkpoint)}", where=where, right=right)
    return checkpoint


def check_publish(graph: Graph, text: GraphText) -> None:
    """Refuse paths that are taken, folders, inputs of the graph, and suffixes that a type does not write."""
    taken: dict[Path, str] = {}
    for node in graph.nodes.values():
        if node.publish is None:
            continue
        frames = graph.all_frames if node.per_frame else [None]
        path = next(iter(graph.files.keys() & map(node.publish_path, frames)), node.publish)
        is_folder = os.path.isdir(path)  # noqa: PTH112 - False where it is inaccessible
        role = taken.get(path) or graph.role(path) or ("a folder" if is_folder else None)
        where = text.place(node.name, ["publish"])
        if role:
            raise BadInput(f"publish: {path} is {role}", where=where, right="a path of its own")
        if path.suffix.lower() not in node.type.writes:
            what = f"{node.type.name} does not write '{path.suffix}' files"
            right = ", ".join(node.type.writes)
            raise BadInput(f"publish: {path}: {what}", where=where, right=f"a name that ends in {right}")
        taken[node.publish] = f"published by '{node.name}' too"


def sort_nodes(nodes: dict[str, Node], path: Path) -> list[str]:
    """Sort nodes topologically, otherwise in the order of the file; BadInput for a cycle."""
    try:
        needs = {node.name: [edge.node for edge in node.edges.values()] for node in nodes.values()}
        return list(TopologicalSorter(needs).static_order())
    except CycleError as error:
        what = f"a cycle: {' -> '.join(reversed(error.args[1]))}"
        raise BadInput(what, where=path, right="edges without a cycle") from None
