"""Level sets and densities as OpenVDB files, written without OpenVDB, whose module has no wheel for each Python.

The file is an archive of version 224, which any OpenVDB since 4.0 (2016) reads. A grid is a tree: the root has nodes of
32^3 children, they have nodes of 16^3, and those have leaves of 8^3 voxels: bricks of a level set, bit for bit. Layout
after OpenVDB's io/Archive.cc, tree/RootNode.h, tree/InternalNode.h, tree/LeafNode.h and io/Compression.h.
"""

import hashlib
import math
import struct
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.vdb_read import MAGIC, UUID
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.values import Density, LevelSet

VERSION = 224
LIBRARY = (10, 0)
"""Release of OpenVDB with this layout; readers do not use it."""
BRANCHES = (5, 4)
"""Base 2 logarithms of the number of children along an axis, of the nodes below the root and of those below them."""
ACTIVE_VALUES_ONLY = 2
"""Compression of a grid: of inactive values only the sign is stored (COMPRESS_ACTIVE_MASK)."""
ALL_BACKGROUND, SIGNED_BACKGROUND = b"\0", b"\3"
"""Inactive values of a node: the background, or plus and minus the background, by a bit each, 1 for plus."""

Fact = str | bool | int | float | tuple[int, ...]
"""A piece of metadata."""
FORMS = {bool: ("bool", "<?"), int: ("int64", "<q"), float: ("double", "<d"), tuple: ("vec3i", "<3i")}
"""Names and layouts of metadata that are numbers."""


class Tree(NamedTuple):
    """Values of a grid.

    leaves      indices of the leaves: of their first voxels, over 8, (N, 3) int
    values      at their voxels, (N, 8, 8, 8) or (N, 8, 8, 8, 3) float32
    active      active voxels; (N, 8, 8, 8) bool
    outside     inactive voxels that are outside, like all places without a leaf; as `active`, or None for a grid
                without a sign
    inside      indices of blocks of 8^3 voxels that are inside and have no leaf, (M, 3) int
    background  of places outside
    voxel       length of a voxel [m]
    """

    leaves: np.ndarray
    values: np.ndarray
    active: np.ndarray
    outside: np.ndarray | None
    inside: np.ndarray
    background: float
    voxel: float


class Grid(NamedTuple):
    """A grid, and its metadata without the extent."""

    name: str
    tree: Tree
    facts: Mapping[str, Fact]


def write(path: Path, grids: Sequence[Grid], frame: int, half: bool = False) -> None:
    """Write grids as an OpenVDB file.

    frame  number of the frame, kept as metadata
    half   keep 16 bits of every value: half the size, with a relative error of at most 1 / 2000

    The same values give the same bytes. Raise BadInput where a value is too large for 16 bits.
    """
    own = {"creator": "hairpipe", "file_units": "metres", "frame": frame}
    data = bytearray(struct.pack("<q3I?", MAGIC, VERSION, *LIBRARY, True) + bytes(36) + metadata(own))
    data += struct.pack("<I", len(grids))
    for grid in grids:
        facts = {**own, "voxel": grid.tree.voxel, "is_saved_as_half_float": half, "name": grid.name, **grid.facts}
        kind = "Tree_float_5_4_3" if grid.tree.values.ndim == 4 else "Tree_vec3s_5_4_3"
        add_grid(data, kind, grid.tree, facts, half)
    digest = hashlib.sha256(data).hexdigest()
    data[UUID] = "-".join([digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]]).encode()
    path.write_bytes(data)


def add_grid(data: bytearray, kind: str, tree: Tree, facts: Mapping[str, Fact], half: bool) -> None:
    """Append a grid to a file, in place; its name is among its metadata."""
    if half:
        most = float(np.abs(tree.values).max(initial=0.0))
        if most > np.finfo(np.float16).max:
            what = f"'{facts['name']}' has values up to {most:.3g}, too large for 16 bits"
            raise BadInput(what, where="half", right="false")
        tree = tree._replace(values=tree.values.astype(np.float16), background=float(np.float16(tree.background)))
    data += text(str(facts["name"])) + text(kind + "_HalfFloat" * half) + text("")
    start = len(data) + struct.calcsize("<3q")
    head = struct.pack("<I", ACTIVE_VALUES_ONLY) + metadata({**facts, **extent_of(tree)})
    scales = (tree.voxel, tree.voxel, 1 / tree.voxel, 1 / tree.voxel**2, 0.5 / tree.voxel)
    head += text("UniformScaleMap") + b"".join(struct.pack("<3d", s, s, s) for s in scales) + b"".join(topology(tree))
    values = b"".join(buffers(tree))
    data += struct.pack("<3q", start, start + len(head), start + len(head) + len(values)) + head + values


def extent_of(tree: Tree) -> dict[str, Fact]:
    """Return the number of active voxels and the corners of their box, as indices."""
    leaf, *within = np.nonzero(tree.active)
    if not len(leaf):
        return {"file_voxel_count": 0}
    voxels = BRICK * tree.leaves[leaf] + np.stack(within, axis=1)
    low, high = (tuple(corner.tolist()) for corner in (voxels.min(axis=0), voxels.max(axis=0)))
    return {"file_bbox_min": low, "file_bbox_max": high, "file_voxel_count": len(leaf)}


def topology(tree: Tree) -> Iterator[bytes]:
    """Yield the nodes from the root down, and the active masks of the leaves."""
    background = np.float32(tree.background).tobytes() * (1 if tree.values.ndim == 4 else 3)
    blocks = np.concatenate([tree.leaves, tree.inside])
    roots = np.unique(blocks >> sum(BRANCHES), axis=0)
    yield struct.pack("<I", 1) + background + struct.pack("<2I", 0, len(roots))
    is_leaf = np.arange(len(blocks)) < len(tree.leaves)
    masks = bits(tree.active)
    for root in roots:
        yield struct.pack("<3i", *(root << (sum(BRANCHES) + 3)))
        own = np.flatnonzero((blocks >> sum(BRANCHES) == root).all(axis=1))
        yield from node(tree, masks, BRANCHES, blocks[own], np.where(is_leaf, np.arange(len(blocks)), -1)[own])


def node(
    tree: Tree, masks: np.ndarray, branches: tuple[int, ...], blocks: np.ndarray, leaf: np.ndarray
) -> Iterator[bytes]:
    """Yield an internal node and its children.

    masks     of the leaves, (N, 64) uint8
    branches  `BRANCHES` from this node down
    blocks    indices of the blocks of 8^3 voxels in it, (n, 3) int
    leaf      indices of their leaves, -1 where a block has none and is inside, (n,) int
    """
    log2 = branches[0]
    below = branches[1:]
    x, y, z = ((blocks >> sum(below)) & (2**log2 - 1)).T
    child = (x << 2 * log2) | (y << log2) | z
    is_child = np.zeros(8**log2, bool)
    is_outside = np.ones(8**log2, bool)
    is_child[child if below else child[leaf >= 0]] = True
    is_outside[child[leaf < 0]] = bool(below)
    signs = ALL_BACKGROUND if tree.outside is None else SIGNED_BACKGROUND + bits(is_outside[None]).tobytes()
    yield bits(is_child[None]).tobytes() + bytes(8**log2 // 8) + signs
    for place in np.flatnonzero(is_child):
        own = child == place
        if below:
            yield from node(tree, masks, below, blocks[own], leaf[own])
        else:
            yield masks[leaf[own][0]].tobytes()


def buffers(tree: Tree) -> Iterator[bytes]:
    """Yield the active values of the leaves, and the signs of the others."""
    masks = bits(tree.active)
    signs = None if tree.outside is None else bits(tree.outside & ~tree.active)
    for leaf, active in enumerate(tree.active):
        inactive = ALL_BACKGROUND if signs is None else SIGNED_BACKGROUND + signs[leaf].tobytes()
        yield masks[leaf].tobytes() + inactive + tree.values[leaf][active].tobytes()


def bits(flags: np.ndarray) -> np.ndarray:
    """Pack flags, 8 to a byte, the first one lowest: (n, ...) bool to (n, m) uint8."""
    return np.packbits(flags.reshape(len(flags), math.prod(flags.shape[1:])), axis=1, bitorder="little")


def text(value: str) -> bytes:
    return struct.pack("<I", len(value.encode())) + value.encode()


def metadata(facts: Mapping[str, Fact]) -> bytes:
    entries = b"".join(text(name) + entry(facts[name]) for name in sorted(facts))
    return struct.pack("<I", len(facts)) + entries


def entry(fact: Fact) -> bytes:
    if isinstance(fact, str):
        return text("string") + text(fact)
    name, form = FORMS[type(fact)]
    data = struct.pack(form, *(fact if isinstance(fact, tuple) else (fact,)))
    return text(name) + struct.pack("<I", len(data)) + data


_VECTORS = {"class": "unknown", "vector_type": "contravariant relative"}


def surface_grids(surface: LevelSet) -> list[Grid]:
    """Return `surface`, a level set, and `vel`, vectors in the band."""
    band = {"half_width": surface.half_width}
    return [
        Grid("surface", surface_tree(surface), {"class": "level set", **band}),
        Grid("vel", velocity_tree(surface), {**_VECTORS, **band}),
    ]


def density_grids(density: Density) -> list[Grid]:
    """Return `density`, a fog of the length of hair per volume [m/m^3], and `hair_vel`, vectors where there is hair."""
    empty = np.empty((0, 3), int)
    first = density.low // BRICK
    before = density.low - BRICK * first
    after = -(before + density.length.shape) % BRICK
    wide = [(int(a), int(b)) for a, b in zip(before, after, strict=True)]
    blocks = [_blocks(np.pad(density.length, wide)), _blocks(np.pad(density.velocity, [*wide, (0, 0)]))]
    places = np.argwhere((blocks[0] > 0.0).any(axis=(3, 4, 5)))
    places = places[order_in_tree(first + places)]
    length, velocity = (values[tuple(places.T)] for values in blocks)
    leaves = first + places
    active = length > 0.0
    return [
        Grid("density", Tree(leaves, length, active, None, empty, 0.0, density.cell), {"class": "fog volume"}),
        Grid("hair_vel", Tree(leaves, velocity, active, None, empty, 0.0, density.cell), _VECTORS),
    ]


def _blocks(values: np.ndarray) -> np.ndarray:
    """Return values of whole blocks block by block, (na, nb, nc, 8, 8, 8, ...)."""
    a, b, c = (n // BRICK for n in values.shape[:3])
    parted = values.reshape(a, BRICK, b, BRICK, c, BRICK, *values.shape[3:])
    return np.moveaxis(parted, (2, 4), (1, 2))


def surface_tree(surface: LevelSet) -> Tree:
    """Return the distance, active in the band; beyond it is the width of the band with the distance's sign."""
    background = np.float32(surface.voxel * surface.half_width)
    leaves, bricks = leaves_of(surface)
    distance = surface.distance[bricks, :BRICK, :BRICK, :BRICK]
    inside = first_leaf(surface) + np.argwhere(surface.bricks == LevelSet.FAR_INSIDE)
    return Tree(leaves, distance, np.abs(distance) < background, distance > 0, inside, float(background), surface.voxel)


def velocity_tree(surface: LevelSet) -> Tree:
    """Return the velocity in the band; 0 beyond it."""
    leaves, bricks = leaves_of(surface)
    distance, velocity = (values[bricks, :BRICK, :BRICK, :BRICK] for values in (surface.distance, surface.velocity))
    active = (np.abs(distance) < np.float32(surface.voxel * surface.half_width)) & velocity.any(axis=-1)
    kept = active.any(axis=(1, 2, 3))
    return Tree(leaves[kept], velocity[kept], active[kept], None, np.empty((0, 3), int), 0.0, surface.voxel)


def leaves_of(surface: LevelSet) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the bricks' leaves, (B, 3) int, and of the bricks, (B,) int, in the order of a tree."""
    places = np.argwhere(surface.bricks >= 0)
    leaves = first_leaf(surface) + places
    order = order_in_tree(leaves)
    return leaves[order], surface.bricks[tuple(places[order].T)]


def first_leaf(surface: LevelSet) -> np.ndarray:
    """Return the index of the leaf of the first block of the bricks' lattice, (3,) int."""
    return np.rint(surface.origin / (BRICK * surface.voxel)).astype(int)


def order_in_tree(leaves: np.ndarray) -> np.ndarray:
    """Return the order of leaves, (N, 3) int, in a tree: by their nodes, from the root down."""
    units = [leaves >> sum(BRANCHES[level:]) for level in (0, 1, 2)]
    return np.lexsort(np.concatenate(units, axis=1).T[::-1])
