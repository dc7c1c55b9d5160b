"""The engine: node declarations, store, graph files, keys, plan and run. It knows nothing of hair.

Its folders build on each other in the order node, store, file, key, plan, worker, engine, run. Authors of nodes import
from here alone:

    @node(frames="each")
    def soften(number: Pair[Number], other: Number | None = None, *, factor: float = 0.5) -> Number:
        ...  # the docstring is the help: a first line, then a line `factor  of the previous frame` for each setting

`node`       declares a typed pure function as a node type of its name, in a file of that name. Parameters before `*`
             are inputs, those after it settings; the result is the output, a NamedTuple is several
`frames=`    "once": a value for the shot; "each": one per frame; "scan": one per frame, from the parameter `previous`,
             which is the output of the same type at the frame before, None at the first
`prepare=`   a function of the module, whose result a node per frame takes as its parameter `prepared`, and must not
             change. Its parameters are some of the node's inputs, those that are the same at all frames, and settings,
             by the same names. A worker calls it once for equal values of those; the result is never stored

An input is annotated with its type `T`, or with what the node sees of it over time, each possibly `| None`, or as a
`tuple[..., ...]` of any number of them:

`Pair[T]`    the value at the frame before and at this one
`Frames[T]`  the values at all frames of the run, read when asked for
`Reached[T]` the same, up to the frame at which a scan diverged; a scan that diverges raises ArithmeticError
`Frames[Spent]`, `Reached[Spent]`  the time that each result took, of a node with values of any type

A parameter of type `Time` gives the frame and its length, one of type `Cuts` the frames at which the shot is cut, one
of type `First` the first frame of the shot, one of type `Origin` the nodes and settings behind the result, one of type
`Workspace` an empty folder for a `File`, a value that the graph can publish. A node raises `BadInput` for input that
the user can fix; its warnings are reported.
`@flat_group("settings")` makes the fields of that group settings of the node itself.
"""

from hairpipe.engine.node.declare import (
    Cuts,
    File,
    First,
    Frames,
    Origin,
    Pair,
    Reached,
    Spent,
    Time,
    Workspace,
    flat_group,
    node,
)

__all__ = [
    "Cuts",
    "File",
    "First",
    "Frames",
    "Origin",
    "Pair",
    "Reached",
    "Spent",
    "Time",
    "Workspace",
    "flat_group",
    "node",
]
