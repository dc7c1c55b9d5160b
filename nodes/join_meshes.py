"""Several bodies as one."""

from hairpipe.data import Mesh
from hairpipe.graph import node


@node(frames="each")
def join_meshes(meshes: tuple[Mesh, ...]) -> Mesh:
    """Combine meshes into one, each at its place and with its motion."""
    from hairpipe.body.shapes import join

    return join(meshes)
