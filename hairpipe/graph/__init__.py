"""The engine: graph files, node declarations, keys, store, plan and run. It knows nothing of hair.

What node types use is named here; everything else is imported from the module that defines it.
"""

from hairpipe.graph.node.declare import node
from hairpipe.graph.node.files import File, Workspace
from hairpipe.graph.node.frames import Frames, Pair, Reached, Time

__all__ = ["File", "Frames", "Pair", "Reached", "Time", "Workspace", "node"]
