"""What fails."""

import warnings

from hairpipe.engine import Time, node
from hairpipe.values import Strands, Table


@node(frames="each")
def tear(hair: Strands, time: Time) -> Table:
    """Nothing, since it fails at frame 3, and warns at frame 4."""
    if time.frame == 4:
        warnings.warn("frayed", stacklevel=1)
    if time.frame == 3:
        raise ValueError(f"</script> at frame {time.frame}")
    return Table((), {}, {})
