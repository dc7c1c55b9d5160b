"""Preparations of nodes: computed once per process for many frames, never stored."""

import gc
import json
from collections import OrderedDict
from collections.abc import Callable
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from hairpipe.graph.node.declare import PREPARED, NodeType
from hairpipe.graph.node.messages import recorded_warnings
from hairpipe.graph.node.settings import build_settings
from hairpipe.graph.plan.arguments import Load, Named, build_inputs

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
            self._make_room(made.nbytes)
            self._kept[key] = made
        self._kept.move_to_end(key)
        return self._kept[key]

    def _make_room(self, nbytes: int) -> None:
        """Remove the least recently used results until another of this size can be kept."""
        while len(self._kept) >= LEAST_KEPT and nbytes + sum(p.nbytes for p in self._kept.values()) > self._memory:
            self._kept.popitem(last=False)


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
