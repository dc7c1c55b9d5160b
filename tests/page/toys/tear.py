"""What fails."""

from hairpipe.data import Strands, Table
from hairpipe.graph import Time, node


@node(frames="each")
def tear(hair: Strands, time: Time) -> Table:
    """Nothing, since it fails at frame 3."""
    if time.frame == 3:
        raise ValueError(f"</script> at frame {time.frame}")
    return Table((), {}, {})
