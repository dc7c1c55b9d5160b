"""Roots bound to the body, Sec. 6 of Selle, Lentine, Fedkiw 2008: a point of a triangle, and the triangle's frame.

We differ from the paper, which embeds the first points of a hair in tetrahedra of a head that deforms. Where roots lie
off the body, each known cause is tested: it applies if its correction moves the roots onto the body.
"""

import warnings
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import root_frames
from hairpipe.geometry.triangle_tree import Tree, nearest_sites, project, tree_over
from hairpipe.values import Groom, Mesh, Strands
from hairpipe.values.strand_arrays import FREE, name_strands
from hairpipe.values.triangles import Sites

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
    what: str
    right: str


def cause_of_misfit(mesh: Mesh, roots: np.ndarray, tips: np.ndarray, reach: float) -> Cause | None:
    """Return the cause of roots not within reach [m] of a body, from both ends of strands (S, 3), if one is found."""
    tree = tree_over(mesh.points[mesh.triangles])
    chosen = np.unique(np.linspace(0, len(roots) - 1, SAMPLED).astype(np.int64))
    roots, tips = roots[chosen], tips[chosen]
    if share_on(tree, tips, reach) >= MOST:
        return Cause("the other ends lie on it: strands begin at the tip", "the root as first point of a strand")
    for turn, matrix in TURNS.items():
        for scale in (1.0, *(ratio for length in UNITS for ratio in (length, 1.0 / length))):
            moved = scale * roots @ matrix.T
            apart = np.ptp(moved, axis=0).max(initial=0.0) > WIDE * reach  # a smaller set of places fits anywhere
            if (turn or scale != 1.0) and apart and share_on(tree, moved, reach) >= MOST:
                size = UNITS.get(scale) or UNITS.get(1.0 / scale, "")
                finer, other = ("hair", "the body") if scale < 1.0 else ("the body", "hair")
                parts = [f"{finer} is in units of {size}, {other} in metres"] if size else []
                parts += [f"hair has {turn}"] if turn else []
                return Cause(", and ".join(parts), "one unit and one up axis of hair and body")
    offset = common_offset(mesh, tree, roots, reach)
    if offset is None:
        return None
    vector = ", ".join(f"{x:.4g}" for x in np.round(offset, 4) + 0.0)
    right = "points with one transform; the present ones may have been transformed twice"
    return Cause(f"all are displaced by one vector, ({vector}) m", right)


def share_on(tree: Tree, places: np.ndarray, reach: float) -> float:
    finite = places[np.isfinite(places).all(axis=1)]
    return float((project(tree, finite)[1] <= reach).mean()) if len(finite) else 0.0


def common_offset(mesh: Mesh, tree: Tree, roots: np.ndarray, reach: float) -> np.ndarray | None:
    """Return the offset of roots from a body [m], if there is one: ICP [Besl and McKay 1992] by translations alone."""
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


SOME = 0.1  # share of roots far off a body that have one cause
TIPS = ("tip_triangles", "tip_barycentrics", "tip_frames")  # fields of a groom some of whose tips are held


def bind_roots(mesh: Mesh, roots: np.ndarray, tips: np.ndarray, reach: float, ids: np.ndarray) -> Sites:
    """Return the sites of a mesh closest to the roots [m], (S, 3).

    A root off the surface keeps its position: it has constant coordinates in the frame of its site, and moves with it.
    Raises BadInput naming strands by their ids, (S,), whose roots lie farther than reach [m] from the mesh, with the
    cause if the roots and the tips [m], (S, 3), reveal it.
    """
    sites, distances = nearest_sites(mesh, roots)
    far = distances > reach
    if far.any():
        what = f"roots up to {distances.max():.3g} m away from the body: {name_strands(ids[far])}"
        cause = cause_of_misfit(mesh, roots, tips, reach) if far.mean() > SOME else None
        within = f"every root within reach = {reach:g} m of the body"
        raise BadInput(f"{what}; {cause.what}" if cause else what, right=cause.right if cause else within)
    return sites


def bind_tips(mesh: Mesh, groom: Groom, held: np.ndarray, reach: float) -> Groom:
    """Return the groom with its held tips, (S,) bool, bound to the closest sites of a mesh; pure.

    A tip off the surface moves with its site, like a root; warns of those farther than reach [m], by their ids.
    """
    if not held.any():
        return groom
    sites, distances = nearest_sites(mesh, groom.points[groom.offsets[1:] - 1])
    if len(far := groom.ids[held & (distances > reach)]):
        message = f"{len(far)} tips are bound to a place of the body more than reach = {reach:g} m away"
        warnings.warn(f"{message}: {name_strands(far)}", stacklevel=3)
    frames = root_frames(mesh.points, mesh.triangles, *sites)
    triangles = np.where(held, sites.triangles, FREE).astype(np.int32)
    return replace(groom, tip_triangles=triangles, tip_barycentrics=sites.barycentrics, tip_frames=frames)


def rigid_strands(groom: Groom, motions: np.ndarray, rates: np.ndarray, diameter: float) -> Strands:
    """Return the strands of a groom, moved by motions of their roots, with their time derivatives, (S, 3, 4); pure."""
    strand = np.repeat(np.arange(len(groom.ids)), np.diff(groom.offsets))
    placed = np.concatenate([groom.points, np.ones((len(groom.points), 1))], axis=1)
    points, velocities = (np.einsum("pij,pj->pi", bound[strand], placed) for bound in (motions, rates))
    return Strands(points, velocities.astype(np.float32), groom.offsets, diameter)
