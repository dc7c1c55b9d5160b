"""Default body: a bust."""

from hairpipe.engine import node
from hairpipe.values import Body


@node(frames="once")
def make_bust() -> Body:
    """Build head, neck and shoulders of a mannequin as one closed mesh, rigged, with maps "scalp" and "length"."""
    from hairpipe.body.bust import build_bust

    return build_bust()
