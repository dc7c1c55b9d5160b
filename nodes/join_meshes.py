"""Several bodies as one."""

from hairpipe.data import Mesh
from hairpipe.graph import node


@node(frames="each")
def join_meshes(meshes: tuple[Mesh, ...]) -> Mesh:
    """All meshes in one, each where it is and as it moves."""
    from hairpipe.body.shapes import join

    return join(meshes)
