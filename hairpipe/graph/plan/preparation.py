"""What nodes are prepared with: computed once a process for many frames, never stored."""

import json
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, NamedTuple

from hairpipe.graph.node.declare import PREPARED, NodeType
from hairpipe.graph.node.messages import recorded_warnings
from hairpipe.graph.node.settings import build_settings
from hairpipe.graph.plan.arguments import Load, Named, build_inputs

MOST_KEPT = 2
"""Results that are kept of each function."""


class Prepared(NamedTuple):
    """Arguments of a node in addition to inputs and settings, and the warnings of their preparation."""

    arguments: dict[str, Any]
    warnings: tuple[str, ...] = ()


class Preparations:
    """Calls the `prepare` functions of node types, and keeps the latest results of each.

    A result is looked up by the names of its objects and by its settings: no array is compared.
    """

    def __init__(self) -> None:
        self._kept: dict[Callable[..., Any], OrderedDict[str, Prepared]] = {}

    def prepare(self, node_type: NodeType, named: Named, settings: dict[str, Any], load: Load) -> Prepared:
        """Prepare a node, or return its previous preparation; an exception of the function is propagated.

        The function receives its own values: a node that writes to its inputs does not change the preparation.
        """
        preparation = node_type.prepare
        if preparation is None:
            return Prepared({})
        sockets = [node_type.sockets[name] for name in preparation.sockets]
        inputs = {plug: named[plug] for socket in sockets for plug in socket.plugs(named)}
        key = json.dumps([inputs, {name: settings[name] for name in preparation.settings}])
        kept = self._kept.setdefault(preparation.function, OrderedDict())
        if key not in kept:
            built = build_settings(node_type, settings)
            arguments = build_inputs(sockets, inputs, load) | {name: built[name] for name in preparation.settings}
            while len(kept) >= MOST_KEPT:
                kept.popitem(last=False)
            with recorded_warnings() as warnings:
                result = preparation.function(**arguments)
            kept[key] = Prepared({PREPARED: result}, tuple(warnings))
        kept.move_to_end(key)
        return kept[key]
