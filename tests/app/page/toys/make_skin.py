"""A body to paint on."""

import numpy as np

from hairpipe.engine import node
from hairpipe.values import Body, Mesh, Skeleton

CELLS = 8


@node(frames="once")
def make_skin(*, bare: bool = False) -> Body:
    """A square of 20 cm that faces +Z, with a map that grows with y.

    bare  whether it has no texture coordinates
    """
    along = np.linspace(0.0, 1.0, CELLS + 1)
    grid = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = (np.arange(CELLS)[:, None] * (CELLS + 1) + np.arange(CELLS)).ravel()[:, None]
    triangles = np.concatenate(
        [corner + np.array(ends) for ends in ((0, CELLS + 1, CELLS + 2), (0, CELLS + 2, 1))]
    ).astype(np.int32)
    points = np.concatenate([0.2 * (grid - 0.5), np.zeros((len(grid), 1))], axis=1)
    mesh = Mesh(points, triangles, uv=None if bare else grid[triangles].astype(np.float32))
    skeleton = Skeleton(("head",), np.array([-1], np.int32), np.eye(4)[None], np.zeros((1, 3)))
    joints = np.zeros((len(points), 1), np.int32)
    return Body(mesh, skeleton, joints, np.ones((len(points), 1)), {"scalp": grid[:, 1].copy()})
