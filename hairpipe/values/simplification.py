"""Simplifications of a simulation, as data: settings of the graph with less physics, or coarser.

A node that simulates hair names the module that lists its own, `@node(..., tuning="my_model.tuning")`. It is named and
not imported, so that what may be tried is not part of the key of a result. The module has any of these functions:

    simplifications(settings, sockets, dt)  lists them for the settings of a node, its connected sockets, and frames of
                                            dt [s]; targets of `puts` and `drops` are settings of the node, as
                                            "steps.longest"
    couples(settings)                       whether hair acts on hair; without this function it does not
"""

from dataclasses import dataclass
from typing import Any

Puts = tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Simplification:
    """One part of the physics left out, or one discretisation made coarser.

    axis        aspect that it simplifies; at most one simplification per axis is used
    level       level on this axis: a higher one omits more
    text        description
    puts        settings by target, with their values
    drops       targets of groups to remove
    keys        number of strands per simulated strand; 1: all are simulated
    instead     function "module:name" that makes nodes to replace the simulation; it is called with the
                name of the node, its table, the edge of the groom of all strands, and the simplification, and returns
                tables by name: that of the same name provides the strands. Empty: the node is kept
    count       number of elements that `instead` simulates in place of at least as many strands
    compatible  axes that can be simplified at the same time; None: all
    """

    axis: str
    level: int
    text: str
    puts: Puts = ()
    drops: tuple[str, ...] = ()
    keys: int = 1
    instead: str = ""
    count: int = 0
    compatible: tuple[str, ...] | None = None
