"""Points of hair pinned to a body: which they are, and where the body carries them."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Groom, Mesh
from hairpipe.data.lengths import fractions_along
from hairpipe.errors import BadInput
from hairpipe.groom.binding import name_strands, nearest_sites, root_frames
from hairpipe.groom.sampling import members_of
from hairpipe.spatial.triangles import Sites


class Pinned(NamedTuple):
    """Pinned points of a groom: indices, (k,) int32, at rest [m], (k, 3), their sites, and the frames of those."""

    points: np.ndarray
    rest: np.ndarray
    sites: Sites
    frames: np.ndarray


def pin(
    groom: Groom,
    mesh: Mesh | None,
    group: str | None,
    at: tuple[float, ...],
    place: tuple[float, float, float] | None,
    reach: float,
) -> Pinned:
    """Bind points of a group of strands, or of all, to a mesh at rest, or without one to the roots of their strands.

    at     fractions of the length, at each of which the nearest point of a strand is pinned
    place  place whose nearest point of each strand is pinned [m]; without it or fractions, that nearest to the mesh
    reach  maximum distance of a pinned point from the mesh [m]

    Raises BadInput for an unknown group, where a strand is farther away, and if neither mesh nor fractions are given.
    """
    counts = np.diff(groom.offsets)
    members = np.ones(len(counts), bool) if group is None else members_of(groom, (group,), "group")
    strands = np.flatnonzero(members)
    if at:
        along = fractions_along(groom.points, groom.offsets)
        ranks = [np.abs(along - fraction) for fraction in at]
    elif place is not None:
        ranks = [np.linalg.norm(groom.points - np.array(place), axis=1)]
    elif mesh is not None:
        ranks = [nearest_sites(mesh, groom.points)[1]]
    else:
        raise BadInput(
            "nothing states which points are pinned", where="at", right="fractions of the length, a place, or in.rest"
        )
    points = np.unique([_lowest(rank, groom.offsets, strands) for rank in ranks]).astype(np.int32)
    owners = np.searchsorted(groom.offsets, points, side="right") - 1
    if mesh is None:
        sites = Sites(groom.root_triangles[owners], groom.root_barycentrics[owners])
        return Pinned(points, groom.points[points], sites, groom.root_frames[owners])
    sites, away = nearest_sites(mesh, groom.points[points])
    if (away > reach).any():
        named = name_strands(groom.ids[np.unique(owners[away > reach])])
        what = f"pinned points up to {away.max():.3g} m away from the body: {named}"
        raise BadInput(what, where="in.rest", right=f"every point within reach = {reach:g} m")
    return Pinned(points, groom.points[points], sites, root_frames(mesh.points, mesh.triangles, *sites))


def _lowest(rank: np.ndarray, offsets: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """Return the point of lowest rank, (P,), of each of some strands but its root, which is held already."""
    return np.array([offsets[s] + 1 + np.argmin(rank[offsets[s] + 1 : offsets[s + 1]]) for s in strands])


def check_mesh(pinned: Pinned, mesh: Mesh) -> None:
    """Raise BadInput where points are pinned to triangles that a mesh does not have."""
    bound = pinned.sites.triangles.max(initial=-1)
    if bound >= len(mesh.triangles):
        what = f"hair is pinned to triangle {bound} of a body that has {len(mesh.triangles)}"
        raise BadInput(what, where="in.body", right="the body of the roots, or in.rest moved")
