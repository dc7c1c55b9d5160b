"""Bodies: meshes, skeletons and their poses, motion capture, level sets, and the density of hair around them."""

from dataclasses import field

import numpy as np

from hairpipe.values.value import value

BRICK = 8
"""Voxels along a side of a brick of a level set."""


@value
class Mesh:
    """Triangles in space, with the velocities of the vertices if they move.

    points      positions [m], (n, 3) float64
    triangles   vertex indices, counter-clockwise seen from outside, (m, 3) int32
    velocities  of the vertices [m/s], (n, 3) float64, or None for a static mesh
    uv          texture coordinates of the triangle corners, (m, 3, 2) float32, or None
    """

    points: np.ndarray
    triangles: np.ndarray
    velocities: np.ndarray | None = None
    uv: np.ndarray | None = None

    @property
    def rates(self) -> np.ndarray:
        """Velocities of the vertices, 0 where the mesh does not move [m/s], (n, 3) float64."""
        return np.zeros_like(self.points) if self.velocities is None else self.velocities


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


@value
class Clip:
    """The joints of a performer and their channels over time; parents precede children.

    names       names of the J joints
    parents     index of the parent joint, -1 at a root, (J,) int32
    offsets     offset of every joint from its parent with all channels zero [file units], (J, 3) float64
    ends        offset of a joint's End Site from the joint [file units], (J, 3) float64, NaN if it has none
    channels    channels of every joint in the order of the file, such as ("Xposition", "Zrotation")
    values      values of all channels, by joint [file units, deg], (F, C) float64; positions replace offsets
    frame_time  duration of a frame [s]
    """

    names: tuple[str, ...]
    parents: np.ndarray
    offsets: np.ndarray
    ends: np.ndarray
    channels: tuple[tuple[str, ...], ...]
    values: np.ndarray
    frame_time: float


@value
class LevelSet:
    """Cubic bricks of 8 voxels a side that cover the narrow band; everything else is far inside or far outside.

    A brick stores the 9 x 9 x 9 samples at the corners of its 8 x 8 x 8 voxels, so a point in it is interpolated
    without its neighbours. Sample (i, j, k) of brick (a, b, c) lies at origin + voxel * (8a+i, 8b+j, 8c+k).
    Blocks far inside have samples at their corners.

    bricks      index of the brick that covers a block of space, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32
    distance    signed distance, negative inside, outside at most voxel*half_width [m], (B, 9, 9, 9) float32
    velocity    of the nearest point of the surface; beyond the band, of one nearby [m/s], (B, 9, 9, 9, 3) float32
    inner       the same at the corners of the blocks that are far inside: distance [m], then velocity [m/s]; elsewhere
                0, (na + 1, nb + 1, nc + 1, 4) float32
    origin      position of the first sample, a multiple of 8 voxels from the world's origin [m], (3,) float64
    voxel       spacing of the samples [m]
    half_width  of the band, in voxels
    """

    FAR_OUTSIDE = -1
    FAR_INSIDE = -2

    bricks: np.ndarray
    distance: np.ndarray
    velocity: np.ndarray
    inner: np.ndarray
    origin: np.ndarray
    voxel: float
    half_width: float


@value
class BodyParts:
    """The parts of a body at one frame; the body is their union.

    A part k is a level set in its own frame: X = R_k^T (x - p_k), with poses[k] = [R_k | p_k] and R_k a rotation. It
    consists of bricks, like a LevelSet. The index of its (na, nb, nc) blocks is stored flat from starts[k] on.

    names       names of the parts: those of their bones
    poses       [R | p] of the parts [m], (G, 3, 4) float64
    rates       their time derivatives [1/s, m/s], (G, 3, 4) float64
    starts      start of every part in `bricks`, (G + 1,) int64
    shapes      number of blocks of a part along the axes, (G, 3) int32
    origins     position of the first sample of a part in its frame [m], (G, 3) float64
    bricks      index of the brick at every block of space, LevelSet.FAR_OUTSIDE or FAR_INSIDE, int32
    distance    signed, negative inside, outside at most voxel*half_width [m], (B, 9, 9, 9) float32
    inner       the same at the corners of blocks, see LevelSet: of all parts, (na + 1) (nb + 1) (nc + 1) of each [m],
                float32
    voxel       spacing of the samples [m]
    half_width  of the band, in voxels
    """

    names: tuple[str, ...]
    poses: np.ndarray
    rates: np.ndarray
    starts: np.ndarray
    shapes: np.ndarray
    origins: np.ndarray
    bricks: np.ndarray
    distance: np.ndarray
    inner: np.ndarray
    voxel: float
    half_width: float


@value
class Density:
    """Density of hair on a box of nodes, 0 outside; node (i, j, k) lies at cell * (low + (i, j, k)).

    low       index of the first node, in cells from the world's origin, (3,) int32
    cell      spacing of the nodes [m]
    length    length of hair per volume [m/m^3], (nx, ny, nz) float32
    velocity  mean velocity of hair, weighted by length; 0 without hair [m/s], (nx, ny, nz, 3) float32
    """

    low: np.ndarray
    cell: float
    length: np.ndarray
    velocity: np.ndarray


def gathered(names: tuple[str, ...], poses: np.ndarray, rates: np.ndarray, parts: list[LevelSet]) -> BodyParts:
    """Return level sets as the parts of a body; pure."""
    starts = np.cumsum([0, *(part.bricks.size for part in parts)])
    firsts = np.cumsum([0, *(len(part.distance) for part in parts)])
    own = zip((part.bricks.ravel() for part in parts), firsts, strict=False)
    bricks = [np.where(index >= 0, index + first, index) for index, first in own]
    return BodyParts(
        names,
        poses,
        rates,
        starts.astype(np.int64),
        np.array([part.bricks.shape for part in parts], np.int32),
        np.array([part.origin for part in parts]),
        np.concatenate(bricks).astype(np.int32),
        np.concatenate([part.distance for part in parts]),
        np.concatenate([part.inner[..., 0].ravel() for part in parts]),
        parts[0].voxel,
        parts[0].half_width,
    )
