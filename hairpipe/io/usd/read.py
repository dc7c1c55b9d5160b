"""Bodies and grooms from USD files (usd, usda, usdc, usdz), in metres with Y up."""

from pathlib import Path

import numpy as np

from hairpipe.data import Body
from hairpipe.io.usd import body, curves
from hairpipe.io.usd.apart import work_apart


def read_body(path: Path, prim: str | None = None) -> Body:
    """Read the meshes of a stage as one body at rest, with the UsdSkel skeletons that move them.

    Polygons become triangles. Float primvars on vertices become maps, `st` texture coordinates; invisible meshes and
    those of purpose proxy or guide are left out. Bound meshes stand in the rest pose of their skeleton, others where
    they are at the earliest time; without any skeleton the body has no joints.

    prim  path of a mesh or of what contains the meshes; the whole stage if not given

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim.
    """
    return work_apart(body.read, path, prim)


def read_curves(path: Path, prim: str | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Read all BasisCurves of a stage at the earliest time as strands, root first.

    Invisible curves and those of purpose proxy are left out; those of purpose guide, too, where there are others.
    Linear and Catmull-Rom curves pass through their points, which are returned as they are; B-spline and Bezier
    curves are evaluated.

    prim  path of curves or of what contains them; the whole stage if not given

    Returns points [m], (p, 3) float64, and offsets: strand s owns points offsets[s]:offsets[s+1], (S+1,) int32.

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim and the curve.
    """
    return work_apart(curves.read, path, prim)
