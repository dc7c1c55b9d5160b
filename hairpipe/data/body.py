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
class Body:
    """A mesh at rest that a skeleton moves by linear blend skinning, with maps painted on its vertices.

    mesh      at rest, n vertices; Y up, the face looks along +Z
    skeleton  J joints
    joints    indices of the k joints that move a vertex, (n, k) int32
    weights   their weights, each row sums to 1, (n, k) float64
    maps      painted vertex values by name, each (n,) float64 in 0..1; hair grows where "scalp" is not 0
    time      time code at which an animated file was read; hair is read from files at the same time
    """

    mesh: Mesh
    skeleton: Skeleton
    joints: np.ndarray
    weights: np.ndarray
    maps: dict[str, np.ndarray] = field(default_factory=dict)
    time: float | None = None


@value
class Pose:
    """Transforms of the joints of a body's skeleton at one frame, and their rates.

    transforms  joint-to-world matrices [m], (J, 4, 4) float64, in the order of the skeleton
    rates       their time derivatives [1/s, m/s], (J, 4, 4) float64
    """

    transforms: np.ndarray
    rates: np.ndarray
