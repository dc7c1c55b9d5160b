"""Default body: a bust."""

from hairpipe.data import Body
from hairpipe.graph import node


@node(frames="once")
def make_bust() -> Body:
    """Build head, neck and shoulders of a mannequin as one closed mesh, rigged, with maps "scalp" and "length"."""
    from hairpipe.body.mannequin.bust import build_bust

    return build_bust()
