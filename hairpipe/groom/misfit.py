"""Causes of roots off the body: curves from the tip, an offset, another unit or axis, or another time.

Each cause is tested: it applies if its correction moves the roots onto the body.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Mesh
from hairpipe.spatial.closest import project
from hairpipe.spatial.triangle_tree import Tree, tree_over

MOST = 0.9  # share of the roots that lie on the body where a cause is found
SAMPLED = 256  # roots that are tried
UNITS = {0.001: "1 mm", 0.01: "1 cm", 0.0254: "1 inch", 0.1: "1 dm", 0.3048: "1 foot"}
"""Lengths that a unit of one file may have where that of the other is a metre, or the other way round [m]."""
TURNS = {
    "": np.eye(3),
    "Z up in place of Y": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "Y up in place of Z": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
}
WIDE = 4.0  # times the reach, over which roots must spread for a unit or an axis to be told
ROUNDS = 40  # in which an offset is found


class Cause(NamedTuple):
    """Cause and remedy of roots off a body."""

    what: str
    right: str


def cause_of_misfit(mesh: Mesh, roots: np.ndarray, tips: np.ndarray, reach: float) -> Cause | None:
    """Return the cause of roots (S, 3) not within reach [m] of a body; None if no cause is found. Pure.

    tips  other ends of the strands, (S, 3)
    """
    tree = tree_over(mesh.points[mesh.triangles])
    chosen = np.unique(np.linspace(0, len(roots) - 1, SAMPLED).astype(np.int64))
    roots, tips = roots[chosen], tips[chosen]
    if share_on(tree, tips, reach) >= MOST:
        return Cause("the other ends lie on it: strands begin at the tip", "the root as first point of a strand")
    for turn, matrix in TURNS.items():
        for scale in (1.0, *(ratio for unit in UNITS for ratio in (unit, 1.0 / unit))):
            moved = scale * roots @ matrix.T
            apart = np.ptp(moved, axis=0).max(initial=0.0) > WIDE * reach  # a smaller set of places fits anywhere
            if (turn or scale != 1.0) and apart and share_on(tree, moved, reach) >= MOST:
                return Cause(describe_unit(scale, turn), "one unit and one up axis of hair and body")
    offset = common_offset(mesh, tree, roots, reach)
    if offset is not None:
        vector = ", ".join(f"{x:.4g}" for x in np.round(offset, 4) + 0.0)
        right = "points with one transform; the present ones may have been transformed twice"
        return Cause(f"all are displaced by one vector, ({vector}) m", right)
    return None


def describe_unit(scale: float, turn: str) -> str:
    """Describe a unit, or an axis, which makes roots lie on the body."""
    unit = UNITS.get(scale) or UNITS.get(1.0 / scale, "")
    finer, other = ("hair", "the body") if scale < 1.0 else ("the body", "hair")
    parts = [f"{finer} is in units of {unit}, {other} in metres"] if unit else []
    return ", and ".join([*parts, *([f"hair has {turn}"] if turn else [])])


def share_on(tree: Tree, places: np.ndarray, reach: float) -> float:
    """Return the share of places (n, 3) within reach [m] of a body."""
    finite = places[np.isfinite(places).all(axis=1)]
    return float((project(tree, finite)[1] <= reach).mean()) if len(finite) else 0.0


def common_offset(mesh: Mesh, tree: Tree, roots: np.ndarray, reach: float) -> np.ndarray | None:
    """Return the offset of roots (S, 3) from a body [m], (3,); None if there is none.

    The translation to the closest points is iterated [ICP, Besl and McKay 1992], without rotation, from the present
    position, from the middle of the body and from its top.
    """
    lower = mesh.points.min(axis=0)
    upper = mesh.points.max(axis=0)
    middle = 0.5 * (lower + upper)
    centre = 0.5 * (roots.min(axis=0) + roots.max(axis=0))
    top = np.array([middle[0], upper[1] - np.ptp(roots[:, 1]) / 2, middle[2]])
    found = []
    for start in (roots, roots + middle - centre, roots + top - centre):
        moved = start
        for _ in range(ROUNDS):
            sites, _ = project(tree, moved)
            nearest = np.einsum("sk,skx->sx", sites.barycentrics, mesh.points[mesh.triangles[sites.triangles]])
            moved = moved + (nearest - moved).mean(axis=0)
        if share_on(tree, moved, reach) >= MOST:
            found.append((project(tree, moved)[1].mean(), roots[0] - moved[0]))
    return min(found, key=lambda pair: pair[0])[1] if found else None
