"""Arguments of a node: values of its sockets, special parameters, settings."""

from collections.abc import Callable, Iterable
from typing import Any

from hairpipe.graph.node.declare import NodeType, Socket
from hairpipe.graph.node.settings import build_settings
from hairpipe.graph.node.signature import Cuts, First, Frames, Pair, Reached, Spent, Time, Workspace
from hairpipe.graph.plan.tasks import Inputs, Source

Named = dict[str, Any]
"""Names of the inputs of a task, by plug: a name, two of a `Pair`, [[frame, name], ...] of `Frames`, or None."""
Load = Callable[[Any, type], Any]
"""Loads a value by type and name."""


def name_inputs(
    node_type: NodeType,
    inputs: Inputs,
    frames: tuple[int, ...],
    name: Callable[[Source], Any],
    key: Callable[[Source], Any] | None = None,
) -> Named:
    """Name the inputs of a task, in the shape of the view.

    frames  of a `Frames` socket
    name    returns the name of the object of a source
    key     returns the key of the result of a source, for a socket of type `Spent`
    """
    named: Named = {}
    for socket in node_type.sockets.values():
        for plug in socket.plugs(inputs):
            named_by = key if key is not None and socket.type is Spent else name
            found = [named_by(source) for source in inputs.get(plug, ())]
            if socket.view in ("frames", "reached") and found:
                whole = socket.view == "frames"
                named[plug] = [list(pair) for pair in zip(frames, found, strict=whole)]
            else:
                named[plug] = (found if socket.view == "pair" else found[0]) if found else None
    if node_type.state is not None:
        named["previous"] = next((name(source) for source in inputs.get("previous", ())), None)
    return named


def build_arguments(
    node_type: NodeType,
    named: Named,
    settings: dict[str, Any],
    moment: tuple[Time, Cuts, First],
    folder: Workspace | None,
    load: Load,
) -> dict[str, Any]:
    """Build the arguments of a node from the names of its inputs and plain settings.

    moment  time, cuts and first frame for the node
    folder  workspace, for a node with this parameter
    """
    arguments = build_inputs(node_type.sockets.values(), named, load)
    time, cuts, first = moment
    arguments |= dict.fromkeys(node_type.asks_time, time)
    arguments |= dict.fromkeys(node_type.asks_cuts, cuts)
    arguments |= dict.fromkeys(node_type.asks_first, first)
    arguments |= dict.fromkeys(node_type.asks_workspace, folder)
    if node_type.state is not None:
        previous = named["previous"]
        arguments["previous"] = None if previous is None else load(previous, node_type.outputs[node_type.state])
    return arguments | build_settings(node_type, settings)


def build_inputs(sockets: Iterable[Socket], named: Named, load: Load) -> dict[str, Any]:
    """Load the values of sockets by their names."""
    inputs: dict[str, Any] = {}
    for socket in sockets:
        seen = tuple(see(named.get(plug), socket, load) for plug in socket.plugs(named))
        inputs[socket.name] = (seen or None) if socket.many else seen[0]
    return inputs


def see(given: Any, socket: Socket, load: Load) -> Any:
    """Load the value of a socket; `Frames` are loaded on access."""
    if given is None:
        return None
    if socket.view == "now":
        return load(given, socket.type)
    if socket.view == "pair":
        return Pair(*(load(name, socket.type) for name in given))
    names = dict(given)
    view = Reached if socket.view == "reached" else Frames
    return view(tuple(names), lambda frame: load(names[frame], socket.type))
