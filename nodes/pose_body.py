"""The body at a frame."""

from hairpipe.data import Body, Mesh, Pose
from hairpipe.graph import node


@node(frames="each")
def pose_body(rest: Body, pose: Pose | None = None) -> Mesh:
    """Deform the body's skin by a pose, with the velocity of every vertex; without a pose it is at rest."""
    from hairpipe.body.skinning import skin

    return skin(rest, pose)
