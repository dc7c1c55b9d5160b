"""Choice of the shape of a file, points or rest points, whose roots lie on the body."""

from dataclasses import replace

import numpy as np

from hairpipe.data import Mesh
from hairpipe.data.curves import Curves
from hairpipe.spatial.closest import project
from hairpipe.spatial.triangle_tree import Tree, tree_over


def placed(mesh: Mesh, curves: Curves) -> Curves:
    """Return the curves as they grow from a mesh, without a rest shape or spare points; pure.

    The rest shape is used if its roots lie at least as near to the skin as those of the points: hair and body of a
    file may be of different times. Curves are used with pinned ends if these lie nearer to the skin: B-splines of hair
    whose first control vertex is the root, as written by Blender, would otherwise begin off the skin. Distances are
    compared by their median over the strands.
    """
    tree = tree_over(mesh.points[mesh.triangles])
    rest = curves.points if curves.rest is None else curves.rest
    shapes = [(shape, spare) for spare in (curves.spare, 0 * curves.spare) for shape in (rest, curves.points)]
    distances = [off(tree, shape, curves.offsets, spare) for shape, spare in shapes]
    shape, spare = shapes[int(np.argmin(distances))]
    first = curves.offsets[:-1] + spare
    last = curves.offsets[1:] - spare
    counts = last - first
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    rows = np.arange(offsets[-1]) + np.repeat(first - offsets[:-1], counts)
    spare = np.zeros_like(curves.spare)
    widths, colours = (None if values is None else values[rows] for values in (curves.widths, curves.colours))
    more = {"rest": None, "widths": widths, "colours": colours}
    return replace(curves, points=shape[rows], offsets=offsets, spare=spare, **more)


def off(tree: Tree, points: np.ndarray, offsets: np.ndarray, spare: np.ndarray) -> float:
    """Return how far roots lie from the skin [m], on the median."""
    roots = points[offsets[:-1] + spare]
    finite = np.isfinite(roots).all(axis=1)
    return float(np.median(project(tree, roots[finite])[1])) if finite.any() else np.inf
