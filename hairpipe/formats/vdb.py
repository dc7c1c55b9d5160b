"""Grids of OpenVDB files, read and written without OpenVDB, whose module has no wheel for each Python.

OpenVDB's own reader trusts the counts in a file: a damaged one can make it allocate all memory. Voxels are those of
grids of floating-point or whole numbers, as OpenVDB since 2014 (version 222) writes them: uncompressed, with zlib, or
with Blosc, for which a library is needed.

We write archives of version 224, which any OpenVDB since 4.0 (2016) reads. A grid is a tree: the root has nodes of 32^3
children, they have nodes of 16^3, and those have leaves of 8^3 voxels: bricks of a level set, bit for bit.

Layout after OpenVDB's Archive, GridDescriptor, MetaMap, tree/RootNode.h, InternalNode.h, LeafNode.h, io/Compression.h
and math/Maps.h; chunks of Blosc after its README_CHUNK_FORMAT.rst.
"""

import hashlib
import importlib
import math
import os
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.openvdb_library import ask, find_openvdb
from hairpipe.plain_file import checked_size
from hairpipe.values import Density, LevelSet
from hairpipe.values.body import BRICK

MAGIC = 0x56444220
OLDEST = 222
UUID = slice(21, 57)
HEADER_NUMBERS = {"vec3i": "<3i", "float": "<f", "double": "<d"}
"""Layouts of metadata that are numbers, by the name of their type."""


class Header(NamedTuple):
    """Header of one grid of a file.

    name        of the grid
    grid_class  "level set", "fog volume", "staggered" or ""
    box         lower and upper corner of its active voxels, as `hairpipe.formats.vdb` wrote it [m]; else None
    """

    name: str
    grid_class: str
    box: tuple[tuple[float, ...], tuple[float, ...]] | None = None


class Unread(BadInput):
    """A sound file of a kind that only OpenVDB's library reads."""


class Cursor:
    """Reader of a file from begin to end; faults state the place."""

    def __init__(self, file: BinaryIO, path: Path) -> None:
        self.file, self.path = file, path
        self.size = os.fstat(file.fileno()).st_size

    def fail(self, what: str, right: str = "an OpenVDB file", kind: type[BadInput] = BadInput) -> BadInput:
        return kind(what, where=f"{self.path}, byte {self.file.tell()}", right=right)

    def bytes(self, count: int) -> bytes:
        if count > self.size - self.file.tell():
            raise self.fail(f"the file ends where {count} bytes should follow")
        return self.file.read(count)

    def numbers(self, form: str) -> tuple:
        return struct.unpack(f"<{form}", self.bytes(struct.calcsize(f"<{form}")))

    def number(self, form: str) -> int:
        return self.numbers(form)[0]

    def text(self) -> str:
        return self.bytes(self.number("I")).decode("utf-8", errors="replace")

    def seek(self, place: int) -> None:
        if not self.file.tell() <= place <= self.size:
            raise self.fail(f"the next grid should be at byte {place} of {self.size}")
        self.file.seek(place)


@contextmanager
def opened(path: Path) -> Iterator[Cursor]:
    checked_size(path, "a readable OpenVDB file")
    try:
        with path.open("rb") as file:
            yield Cursor(file, path)
    except OSError as error:
        raise BadInput(error.strerror or str(error), where=path, right="a readable OpenVDB file") from error


def inspect(path: Path) -> list[Header]:
    """Return the headers of the grids of an OpenVDB file; raises BadInput for a damaged or another file."""
    found = []
    with opened(path) as cursor:
        for name, _ in grids_of(cursor):
            cursor.number("I")
            facts = read_metadata(cursor)
            low, high, voxel = (facts.get(fact) for fact in ("file_bbox_min", "file_bbox_max", "voxel"))
            corners = None
            if low and high and voxel and all(a <= b for a, b in zip(low, high, strict=True)):
                corners = tuple(i * voxel for i in low), tuple(i * voxel for i in high)
            found.append(Header(name, str(facts.get("class", "")).replace("unknown", ""), corners))
    return found


def box(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the corners of the box of the level set `surface` [m]; BadInput where a file of ours has none."""
    found = next((grid.box for grid in inspect(path) if grid.name == "surface" and grid.box), None)
    if found is None:
        raise BadInput("the file has no level set 'surface' of known size", where=path, right="a file of export_vdb")
    return found


def grids_of(cursor: Cursor) -> Iterator[tuple[str, str]]:
    """Yield the name of each grid of a file and the type of its tree, at the first byte of the grid."""
    if cursor.number("q") != MAGIC:
        raise cursor.fail("not an OpenVDB file")
    version, _, _ = cursor.numbers("3I")
    if version < OLDEST:
        raise cursor.fail(f"the file has version {version}", f"version {OLDEST} or later", Unread)
    if not cursor.number("?"):
        what = "the file was written as a stream, without a table of its grids"
        raise cursor.fail(what, "a file that OpenVDB saved", Unread)
    cursor.bytes(UUID.stop - UUID.start)
    read_metadata(cursor)
    for _ in range(checked_count(cursor, 36)):
        name, kind, _ = cursor.text(), cursor.text(), cursor.text()
        start, _, end = cursor.numbers("3q")
        cursor.seek(start)
        yield name.split("\x1e")[0], kind  # OpenVDB appends this character and a number to repeated names
        cursor.seek(end)


def checked_count(cursor: Cursor, least: int) -> int:
    count = cursor.number("I")
    if count * least > cursor.size - cursor.file.tell():
        raise cursor.fail(f"{count} entries are announced, more than the file has room for")
    return count


def read_metadata(cursor: Cursor) -> dict[str, Any]:
    """Return the texts, lengths and places of the next metadata, by name."""
    found: dict[str, Any] = {}
    for _ in range(checked_count(cursor, 12)):
        name, kind = cursor.text(), cursor.text()
        data = cursor.bytes(cursor.number("I"))
        if kind == "string":
            found[name] = data.decode("utf-8", errors="replace")
        elif kind in HEADER_NUMBERS and len(data) == struct.calcsize(HEADER_NUMBERS[kind]):
            first, *others = struct.unpack(HEADER_NUMBERS[kind], data)
            found[name] = (first, *others) if others else first
    return found


ZIP, ACTIVE_MASK, BLOSC = 1, 2, 4
"""Flags of the compression of a grid."""
ONE_VALUE, MASK, MASK_ONE, MASK_TWO, ALL_VALUES = 2, 3, 4, 5, 6
"""Storage of inactive values of a node: one value, a bit for each, that and one or two values, or all of them."""
LEAF = 3
TREE = (4, 5)
"""Base 2 logarithms of the voxels along a leaf, and of the children along the nodes above it, from below."""
NUMBERS = {"float": "f", "double": "d", "int32": "i", "int64": "q"}
"""Characters of the types of values, by the name of their tree."""
MOST_VOXELS = 1 << 26
"""Maximum number of active voxels of a file."""


class Voxels(NamedTuple):
    """The active voxels of a grid.

    indices      (n, 3) int64
    values       (n,) float32
    voxel        length of a voxel, in the unit of the file
    translation  of the voxel of index 0, in the unit of the file, (3,)
    """

    indices: np.ndarray
    values: np.ndarray
    voxel: float
    translation: np.ndarray


class _Coding(NamedTuple):
    """How the values of a grid are stored.

    number  character of their type
    half    whether they are cut to 16 bits
    masked  whether only active values are stored
    packed  whether they are compressed: by a library for Blosc, or by zlib
    """

    number: str
    half: bool
    masked: bool
    packed: bool
    blosc: Any


def read_voxels(path: Path, name: str) -> Voxels:
    """Read the grid of a name in a child process; see `read_here`."""
    return work_apart(read_here, path, name)


def read_here(path: Path, name: str) -> Voxels:
    """Read the grid of a name; kinds of files that are not read here are read by OpenVDB, where it is installed."""
    known = []
    try:
        with opened(path) as cursor:
            for called, kind in grids_of(cursor):
                if called == name:
                    return _read_grid(cursor, name, kind)
                known.append(called)
    except Unread:
        if find_openvdb() is None:
            raise
        found = ask("read", f"{path}, grid '{name}'", path=str(path), name=name)
        return Voxels(found["indices"], found["values"], *_placed(found["matrix"], path))
    raise BadInput(f"the file has no grid '{name}'", where=path, right=", ".join(known) or "a grid")


def _read_grid(cursor: Cursor, name: str, kind: str) -> Voxels:
    if kind.startswith("Tree_pt"):
        raise cursor.fail(f"the grid '{name}' holds points", "a grid of numbers")
    number = NUMBERS.get(kind.removesuffix("_HalfFloat").removeprefix("Tree_").removesuffix("_5_4_3"))
    if number is None:
        raise cursor.fail(f"the grid is a {kind}", "a tree of numbers, in leaves of 8 x 8 x 8", Unread)
    flags = cursor.number("I")
    try:
        blosc = importlib.import_module("blosc") if flags & BLOSC else None
    except ImportError:
        right = "pip install 'hairpipe[vdb]', which installs blosc; or a file saved with zip"
        raise cursor.fail("values are compressed by Blosc", right, Unread) from None
    is_half = kind.endswith("_HalfFloat")
    is_masked = bool(flags & ACTIVE_MASK)
    is_packed = bool(flags & (BLOSC | ZIP))
    coding = _Coding(number, is_half, is_masked, is_packed, blosc)
    read_metadata(cursor)
    voxel, translation = _read_map(cursor)
    if cursor.number("I") != 1:
        raise cursor.fail("a tree has one buffer")
    cursor.number(number)
    tiles = checked_count(cursor, 13 + struct.calcsize(number))
    children = cursor.number("I")
    size = sum(TREE) + LEAF
    found = list[tuple[np.ndarray, np.ndarray]]()
    for _ in range(tiles):
        origin = cursor.numbers("3i")
        value, is_active = cursor.numbers(f"{number}?")
        found.append(_expanded(cursor, origin, value, is_active, size))
    leaves: list[tuple[int, ...]] = []
    for _ in range(children):
        for tile in _read_node(cursor, coding, TREE, cursor.numbers("3i"), leaves):
            found.append(tile)
            if sum(len(values) for _, values in found) > MOST_VOXELS:
                raise cursor.fail(f"tiles have more than {MOST_VOXELS:,} voxels", "a grid of leaves")
    for leaf in leaves:
        active = _bits(cursor.bytes(BRICK**3 // 8))
        values = _read_values(cursor, coding, active)
        places = np.flatnonzero(active)
        found.append((np.stack(np.unravel_index(places, 3 * (BRICK,)), axis=1) + leaf, values[places]))
    indices = np.concatenate([np.empty((0, 3), np.int64), *(part[0] for part in found)])
    values = np.concatenate([np.empty(0, np.float32), *(part[1] for part in found)])
    return Voxels(indices, values, voxel, translation)


def _read_map(cursor: Cursor) -> tuple[float, np.ndarray]:
    """Read the map from indices to space; raise BadInput for rotation, shear and anisotropic scale."""
    kind = cursor.text()
    matrix = np.eye(4)
    if kind == "AffineMap":
        matrix = np.array(cursor.numbers("16d")).reshape(4, 4)
    elif kind in ("ScaleMap", "UniformScaleMap", "ScaleTranslateMap", "UniformScaleTranslateMap"):
        if "Translate" in kind:
            matrix[3, :3] = cursor.numbers("3d")
        matrix[np.arange(3), np.arange(3)] = cursor.numbers("3d")
        cursor.numbers("12d")
    else:
        raise cursor.fail(f"the grid is placed by a {kind}", "a uniform scale, and a translation")
    return _placed(matrix, cursor.path)


def _placed(matrix: np.ndarray, path: Path) -> tuple[float, np.ndarray]:
    """Return length of a voxel and translation, (3,), of a map for row vectors, (4, 4)."""
    voxel = float(matrix[0, 0])
    if not (np.isfinite(matrix).all() and voxel > 0.0 and np.allclose(matrix[:3, :3], voxel * np.eye(3), 1e-6)):
        what = "the grid is rotated, or its voxels are not cubes"
        raise BadInput(what, where=path, right="a uniform scale, and a translation")
    return voxel, matrix[3, :3].copy()


def _read_node(
    cursor: Cursor, coding: _Coding, levels: tuple[int, ...], origin: tuple[int, ...], leaves: list[tuple[int, ...]]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Read an internal node and those below it: yield active tiles, and list the origins of leaves, in place."""
    log2 = levels[-1]
    below = levels[:-1]
    size = sum(below) + LEAF
    is_child, is_active = (_bits(cursor.bytes(8**log2 // 8)) for _ in range(2))
    values = _read_values(cursor, coding, is_active)
    shifts = np.stack(np.unravel_index(np.arange(8**log2), 3 * (2**log2,)), axis=1) << size
    for place in np.flatnonzero(is_active & ~is_child):
        yield _expanded(cursor, tuple(shifts[place] + origin), float(values[place]), True, size)
    for place in np.flatnonzero(is_child):
        corner = tuple((shifts[place] + origin).tolist())
        if below:
            yield from _read_node(cursor, coding, below, corner, leaves)
        else:
            cursor.bytes(BRICK**3 // 8)
            leaves.append(corner)


def _read_values(cursor: Cursor, coding: _Coding, active: np.ndarray) -> np.ndarray:
    """Read the values of a node, (n,) float32; those that are not active are 0."""
    stored = cursor.number("b")
    if not 0 <= stored <= ALL_VALUES:
        raise cursor.fail(f"inactive values have the unknown encoding {stored}")
    kind = np.dtype(f"<{coding.number}")
    cursor.bytes(kind.itemsize * ((stored in (ONE_VALUE, MASK_ONE)) + 2 * (stored == MASK_TWO)))
    if stored in (MASK, MASK_ONE, MASK_TWO):
        cursor.bytes(len(active) // 8)
    masked = coding.masked and stored != ALL_VALUES
    count = int(np.count_nonzero(active)) if masked else len(active)
    if coding.half:
        kind = np.dtype("<f2")
        if count == 0:
            return np.zeros(len(active), np.float32)
    data = _read_data(cursor, count * kind.itemsize, coding)
    found = np.zeros(len(active), np.float32)
    found[active if masked else slice(None)] = np.frombuffer(data, kind)
    return np.where(active, found, np.float32(0.0))


def _read_data(cursor: Cursor, size: int, coding: _Coding) -> bytes:
    """Read bytes that may be compressed; uncompressed ones have a length that is not positive."""
    length = cursor.number("q") if coding.packed else -size
    data = cursor.bytes(abs(length))
    if length > 0:
        data = _unpacked(cursor, data, size, coding.blosc)
    if len(data) != size:
        raise cursor.fail(f"{len(data)} bytes of values where {size} should be")
    return data


def _unpacked(cursor: Cursor, data: bytes, size: int, blosc: Any) -> bytes:
    """Decompress data of zlib, to one byte too many at most, or a chunk of Blosc, whose header has both sizes."""
    if blosc is not None and (len(data) < 16 or struct.unpack("<4xI4xI", data[:16]) != (size, len(data))):
        raise cursor.fail(f"not a chunk of Blosc with {size} bytes of values")
    faults = zlib.error if blosc is None else blosc.blosc_extension.error
    try:
        return zlib.decompressobj().decompress(data, size + 1) if blosc is None else blosc.decompress(data)
    except faults as error:
        raise cursor.fail(f"values cannot be unpacked: {error}") from None


def _expanded(
    cursor: Cursor, origin: tuple[int, ...], value: float, active: bool, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the voxels of a tile of 2^size along an axis, all of one value; none for the value 0."""
    if not active or value == 0.0:
        return np.empty((0, 3), np.int64), np.empty(0, np.float32)
    if 8**size > MOST_VOXELS:
        raise cursor.fail(f"a tile has {8**size:,} voxels", f"at most {MOST_VOXELS:,}")
    indices = np.stack(np.unravel_index(np.arange(8**size), 3 * (2**size,)), axis=1) + np.array(origin)
    return indices, np.full(8**size, value, np.float32)


def _bits(data: bytes) -> np.ndarray:
    return np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little").astype(bool)


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
    return struct.pack("<I", len(facts)) + b"".join(text(name) + entry(facts[name]) for name in sorted(facts))


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
