"""The body at a frame."""

from hairpipe.engine import node
from hairpipe.values import Body, Mesh, Pose


@node(frames="each")
def pose_body(rest: Body, pose: Pose | None = None) -> Mesh:
    """Deform the body's skin by a pose, with the velocity of every vertex; without a pose it is at rest."""
    from hairpipe.body.skinning import skin

    return skin(rest, pose)
