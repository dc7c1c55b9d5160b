"""The engine: graph files, node declarations, keys, store, plan and run. It knows nothing of hair.

What node types use is named here; everything else is imported from the module that defines it.

`@node(frames="scan", prepare=FUNCTION)`: FUNCTION takes inputs that are the same at all frames, and settings, by the
names that the node gives them; its result is the node's parameter `prepared`. A worker calls it once for all frames.
`@flat_group("settings")`: the fields of that group are settings of the node itself.
"""

from hairpipe.graph.node.declare import node
from hairpipe.graph.node.files import File, Workspace
from hairpipe.graph.node.flat_group import flat_group
from hairpipe.graph.node.frames import Frames, Pair, Reached, Time

__all__ = ["File", "Frames", "Pair", "Reached", "Time", "Workspace", "flat_group", "node"]
