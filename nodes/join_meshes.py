"""Several bodies as one."""

from hairpipe.engine import node
from hairpipe.values import Mesh


@node(frames="each")
def join_meshes(meshes: tuple[Mesh, ...]) -> Mesh:
    """Combine meshes into one, each at its place and with its motion."""
    from hairpipe.body.shapes import join

    return join(meshes)
