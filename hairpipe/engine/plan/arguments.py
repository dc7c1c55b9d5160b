"""Arguments of a node: values of its sockets, special parameters, settings.

Preparations of nodes: computed once per process for many frames, never stored.
"""

import gc
import json
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from hairpipe.engine.node.declare import PREPARED, Frames, NodeType, Pair, Reached, Socket, Spent
from hairpipe.engine.node.messages import recorded_warnings
from hairpipe.engine.node.settings import build_settings
from hairpipe.engine.plan.tasks import Inputs, Source

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
    special: Mapping[Any, Any],
    load: Load,
) -> dict[str, Any]:
    """Build the arguments of a node from the names of its inputs and plain settings.

    special  time, cuts, first frame, and the workspace of a node that asks for one, by type
    """
    arguments = build_inputs(node_type.sockets.values(), named, load)
    arguments |= {name: special[kind] for name, kind in node_type.special.items()}
    if node_type.state is not None:
        previous = named["previous"]
        arguments["previous"] = None if previous is None else load(previous, node_type.outputs[node_type.state])
    return arguments | build_settings(node_type, settings)


def build_inputs(sockets: Iterable[Socket], named: Named, load: Load) -> dict[str, Any]:
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


MEMORY = 256 << 20
"""Maximum memory of all kept results [bytes]; the last two are kept in any case.

Scans of one graph advance frame by frame in turn: with fewer results than scans, each would be prepared again at every
frame.
"""
LEAST_KEPT = 2


class Prepared(NamedTuple):
    """Arguments of a node in addition to inputs and settings, the warnings of their preparation, its size [bytes]."""

    arguments: dict[str, Any]
    warnings: tuple[str, ...] = ()
    nbytes: int = 0


class Preparations:
    """Calls the `prepare` functions of node types, and keeps the latest results.

    A result is identified by the names of its objects and by its settings, without a comparison of arrays.

    memory  maximum memory of all kept results [bytes]
    """

    def __init__(self, memory: int = MEMORY) -> None:
        self._memory = memory
        self._kept: OrderedDict[tuple[Callable[..., Any], str], Prepared] = OrderedDict()

    def prepare(self, node_type: NodeType, named: Named, settings: dict[str, Any], load: Load) -> Prepared:
        """Prepare a node, or return its previous preparation; an exception of the function is propagated.

        The function receives copies: a node that writes to its inputs does not change the preparation.
        """
        preparation = node_type.prepare
        if preparation is None:
            return Prepared({})
        sockets = [node_type.sockets[name] for name in preparation.sockets]
        inputs = {plug: named[plug] for socket in sockets for plug in socket.plugs(named)}
        key = preparation.function, json.dumps([inputs, {name: settings[name] for name in preparation.settings}])
        if key not in self._kept:
            built = build_settings(node_type, settings)
            arguments = build_inputs(sockets, inputs, load) | {name: built[name] for name in preparation.settings}
            with recorded_warnings() as warnings:
                result = preparation.function(**arguments)
            made = Prepared({PREPARED: result}, tuple(warnings), nbytes_of(result))
            left = self._memory - made.nbytes
            while len(self._kept) >= LEAST_KEPT and sum(kept.nbytes for kept in self._kept.values()) > left:
                self._kept.popitem(last=False)
            self._kept[key] = made
        self._kept.move_to_end(key)
        return self._kept[key]


def nbytes_of(value: Any) -> int:
    """Sum the arrays that are reachable from a value [bytes]."""
    total = 0
    seen: set[int] = set()
    pending = [value]
    while pending:
        item = pending.pop()
        if id(item) in seen or isinstance(item, type | ModuleType | FunctionType | BuiltinFunctionType):
            continue
        seen.add(id(item))
        if not isinstance(item, np.ndarray):
            pending.extend(gc.get_referents(item))
        elif item.base is None:
            total += item.nbytes
        else:
            pending.append(item.base)
    return total
