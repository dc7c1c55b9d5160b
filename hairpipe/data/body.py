"""A body at rest, and the pose that moves it."""

from dataclasses import field

import numpy as np

from hairpipe.data.mesh import Mesh
from hairpipe.data.value import value


@value
class Skeleton:
    """Joints of a body at rest; parents precede children.

    names    of the joints, J of them
    parents  index of the parent joint, -1 at a root, (J,) int32
    rest     joint-to-world matrices at rest [m], column vectors (x' = R x), (J, 4, 4) float64
    tips     world position of the far end of every joint's bone at rest [m], (J, 3) float64
    """

    names: tuple[str, ...]
    parents: np.ndarray
    rest: np.ndarray
    tips: np.ndarray


@value
class BlendShapes:
    """Displacements of vertices by K weights: blend shapes with in-betweens of USD, morph targets of glTF.

    names     of the weights
    rest      weights of the body at rest, (K,) float64
    shapes    weight of every key, (m,) int32
    meshes    mesh of every key, among those that the body joins, (m,) int32
    places    value of the weight at which a key is reached, never 0, (m,) float64
    rows      first displacement of every key, and their number, (m + 1,) int64
    vertices  displaced by a row, (r,) int32
    offsets   displacement of the bound mesh [m], (r, 3) float64
    """

    names: tuple[str, ...]
    rest: np.ndarray
    shapes: np.ndarray
    meshes: np.ndarray
    places: np.ndarray
    rows: np.ndarray
    vertices: np.ndarray
    offsets: np.ndarray


@value
class Bound:
    """A mesh as it is bound to a skeleton, where this is not the body at rest.

    points  without blend shapes [m], (n, 3) float64
    turns   motion of every joint from there to rest, column vectors [m], (J, 4, 4) float64
    """

    points: np.ndarray
    turns: np.ndarray


@value
class DualQuaternions:
    """Vertices that are skinned by dual quaternions, which do not collapse where joints twist.

    vertices  ascending, (m,) int32
    centres   points about which joints scale them [m], (m, 3) float64
    """

    vertices: np.ndarray
    centres: np.ndarray


@value
class Body:
    """A mesh at rest that blend shapes and a skeleton move, with maps painted on its vertices.

    mesh      at rest, n vertices; Y up, the face looks along +Z
    skeleton  J joints
    joints    indices of the k joints that move a vertex, (n, k) int32
    weights   their weights, each row sums to 1, (n, k) float64
    maps      painted vertex values by name, each (n,) float64 in 0..1; hair grows where "scalp" is not 0
    time      time code at which an animated file was read; hair is read from files at the same time
    dual      vertices that are skinned by dual quaternions; None for linear blending of all
    shapes    blend shapes, which act before the joints, or None
    bound     mesh on which blend shapes and joints act; None for the mesh at rest, at weights of 0
    """

    mesh: Mesh
    skeleton: Skeleton
    joints: np.ndarray
    weights: np.ndarray
    maps: dict[str, np.ndarray] = field(default_factory=dict)
    time: float | None = None
    dual: DualQuaternions | None = None
    shapes: BlendShapes | None = None
    bound: Bound | None = None


@value
class Pose:
    """Transforms of the joints of a body's skeleton at one frame, weights of its blend shapes, and their rates.

    transforms    joint-to-world matrices [m], (J, 4, 4) float64, in the order of the skeleton
    rates         their time derivatives [1/s, m/s], (J, 4, 4) float64
    weights       of the blend shapes of the body, (K,) float64; None for those at rest
    weight_rates  their time derivatives [1/s], (K,) float64
    """

    transforms: np.ndarray
    rates: np.ndarray
    weights: np.ndarray | None = None
    weight_rates: np.ndarray | None = None
