"""The body at a frame."""

from hairpipe.data import Body, Mesh, Pose
from hairpipe.graph import node


@node(frames="each")
def pose_body(rest: Body, pose: Pose | None = None) -> Mesh:
    """The body's skin in a pose, with the velocity of every vertex; at rest where there is no pose."""
    from hairpipe.body.skinning import skin

    return skin(rest, pose)
