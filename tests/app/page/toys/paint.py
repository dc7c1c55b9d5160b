"""A picture a frame."""

import numpy as np
from PIL import Image

from hairpipe.engine import File, Time, Workspace, node
from hairpipe.values import Strands


@node(frames="each")
def paint(hair: Strands, time: Time, workspace: Workspace, *, red: float = 0.5) -> File:
    """A square whose colour changes with time.

    red  share of it
    """
    colour = (255 * np.array([red, (time.frame % 8) / 8, 0.2])).astype(np.uint8)
    path = workspace / "picture.png"
    Image.fromarray(np.broadcast_to(colour, (64, 64, 3)).copy()).save(path)
    return File(path)
