"""Rules for holes in the skin: they show the inside of a head, and hair falls into it."""

from collections.abc import Iterator

import numpy as np

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.roots import Roots, find_roots
from hairpipe.formats.usd.check.scene import Scene, Snapshot

TORN = 0.15  # share of edges with one face, which a bust that is cut off does not reach
FEW = 50  # faces, of which the rim of a patch is a large share


def holes(scene: Scene) -> Iterator[Fault]:
    """Find skins with faces that are declared holes, or that miss faces all over."""
    skins = {roots.mesh.prim.GetPath(): roots for hair in scene.hair if (roots := find_roots(scene, hair))}
    for roots in skins.values():
        mesh = roots.mesh.first
        declared = mesh.array("holeIndices")
        if declared is not None and len(declared):
            standing = _standing(roots, declared)
            message = f"declares {len(declared)} of {len(mesh.counts)} faces holes, on which {standing} strands stand"
            yield Fault(roots.mesh.path("holeIndices"), message)
            continue
        rim, edges = _rim(mesh)
        if len(mesh.counts) > FEW and rim > TORN * edges:
            message = f"leaves {rim} of {edges} edges with one face: faces are missing"
            yield Fault(roots.mesh.path("faceVertexIndices"), message)


def _standing(roots: Roots, faces: np.ndarray) -> int:
    named = roots.hair.first.array("primvars:skinprim")
    return 0 if named is None else int(np.isin(named, faces).sum())


def _rim(mesh: Snapshot) -> tuple[int, int]:
    """Return the number of edges with one face, and of all; points in one place are merged."""
    corners = mesh.corners
    if not mesh.consistent or not len(corners) or corners.min() < 0 or corners.max() >= len(mesh.points):
        return 0, 0
    _, place = np.unique(mesh.points, axis=0, return_inverse=True)
    begins = place.ravel()[corners]
    after = np.arange(len(corners)) + 1
    ends = np.cumsum(mesh.counts)
    after[ends[mesh.counts > 0] - 1] = (ends - mesh.counts)[mesh.counts > 0]
    edges = np.sort(np.stack([begins, begins[after]], axis=1), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, faces = np.unique(edges, axis=0, return_counts=True)
    return int((faces == 1).sum()), len(faces)


RULES = (Rule("holes", "warning", holes),)
