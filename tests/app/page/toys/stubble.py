"""Hair on a body, of painted length."""

import numpy as np

from hairpipe.engine import node
from hairpipe.values import Body, Strands
from hairpipe.values.painting import Paint, PaintedMetres

LENGTH = PaintedMetres(0.02)


@node(frames="once")
def stubble(skin: Body, *, density: Paint | None = None, length: PaintedMetres = LENGTH) -> Strands:
    """A hair on each vertex.

    density  not used
    length   of a hair
    """
    roots = skin.mesh.points
    points = np.stack([roots, roots + np.array([0.0, 0.0, length.value])], axis=1).reshape(-1, 3)
    return Strands(
        points, np.zeros((len(points), 3), np.float32), np.arange(0, len(points) + 1, 2, dtype=np.int32), 1e-4
    )
