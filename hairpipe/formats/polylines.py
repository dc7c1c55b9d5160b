"""Strands of files that state neither unit nor axis, in metres with Y up.

OBJ:    l statements; PLY: elements strand or edge
.data:  USC-HairSalon, little-endian: int32 strands, then for each strand int32 points and float32[3] for each
.bin:   reconstructions such as CT2Hair: the same with float32[7] a point: place, direction, label
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.obj import read_lines
from hairpipe.formats.ply import Columns, Lists, read_ply
from hairpipe.plain_file import content
from hairpipe.values.groom import Curves, numbered

Up = Literal["y", "z"]


def plain_curves(points: np.ndarray, counts: np.ndarray, unit: float, up: Up, **more: Any) -> Curves:
    """Return strands with free tips, numbered by their order; pure.

    points  in the unit and with the axis of the file, (p, 3)
    counts  number of points of each strand, (S,)
    unit    unit of the file [m]
    more    other fields of `Curves`; widths and points at rest are as in the file
    """
    total = len(counts)
    if more.get("widths") is not None:
        more["widths"] = unit * np.asarray(more["widths"], np.float64)
    if more.get("rest") is not None:
        more["rest"] = in_metres(more["rest"], unit, up)
    return Curves(
        in_metres(points, unit, up),
        np.concatenate(([0], np.cumsum(counts))).astype(np.int32),
        np.arange(total, dtype=np.int32),
        np.zeros(total, bool),
        np.zeros(total, np.int64),
        **more,
    )


def in_metres(points: np.ndarray, unit: float, up: Up) -> np.ndarray:
    """Return points of a file, (p, 3), in metres with Y up, float64; pure."""
    x, y, z = points.T.astype(np.float64) * unit
    return np.stack((x, y, z) if up == "y" else (x, z, -y), axis=1)


def join_values(values: Sequence[np.ndarray | None], sizes: Sequence[int], blank: object) -> np.ndarray | None:
    """Return values of all objects of a file, with a blank in those without; None where no object has any. Pure."""
    given = next((found for found in values if found is not None), None)
    if given is None:
        return None
    shapes = [(size, *given.shape[1:]) for size in sizes]
    pairs = zip(values, shapes, strict=True)
    return np.concatenate([np.full(shape, blank, given.dtype) if found is None else found for found, shape in pairs])


def join_maps(maps: Sequence[Mapping[str, np.ndarray]], sizes: Sequence[int]) -> dict[str, np.ndarray]:
    """Return the maps of the curves of all objects, (S,) each: 0 in objects without them. Pure."""
    pairs = [(given, np.zeros(size)) for given, size in zip(maps, sizes, strict=True)]
    return {n: np.concatenate([m.get(n, blank) for m, blank in pairs]) for n in sorted({n for m in maps for n in m})}


def join_groups(
    labels: Sequence[np.ndarray | None], sizes: Sequence[int], names: Sequence[str]
) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Return the group of each strand, (S,) int32, and their names; of several objects without groups each is one."""
    if len(labels) == 1 and labels[0] is None:
        return None, ()
    objects = zip(labels, sizes, names, strict=True)
    return numbered(np.concatenate([np.full(size, name) if own is None else own for own, size, name in objects]))


EDGES = ("vertex1", "vertex2")
COLOURS = ("red", "green", "blue")
READ = {"x", "y", "z", "thickness", *COLOURS}


def read_obj_strands(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the lines of an OBJ file; lines that meet at their ends are one strand; objects or groups are groups."""
    lines = read_lines(path)
    edges = np.stack([lines.corners[:-1], lines.corners[1:]], axis=1)
    edges = np.delete(edges, np.cumsum(lines.sizes)[:-1] - 1, axis=0)
    order, counts = chains(edges, len(lines.points), path)
    points = lines.points[order]
    if len(np.unique(lines.owners)) < 2:
        return plain_curves(points, counts, unit, up)
    owner = np.zeros(len(lines.points), np.int64)
    owner[lines.corners] = np.repeat(lines.owners, lines.sizes)
    firsts = order[np.cumsum(counts) - counts]
    groups, names = numbered(np.array(lines.names)[owner[firsts]])
    return replace(plain_curves(points, counts, unit, up, groups=groups), group_names=names)


def read_ply_strands(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the strands of a PLY file by numbers of segments, nsegs, or by edges; thickness is read as width."""
    elements = read_ply(path)
    vertex = elements.get("vertex", {})
    points = np.stack([column(vertex, name, path, "vertex") for name in "xyz"], axis=1)
    if "strand" in elements:
        counts = whole(column(elements["strand"], "nsegs", path, "strand"), path, "nsegs") + 1
        if (counts < 1).any() or counts.sum() != len(points):
            what = f"nsegs of {len(counts)} strands give {counts.sum()} points"
            raise BadInput(what, where=path, right=f"the number of vertices, {len(points)}")
        order = np.arange(len(points))
    elif "edge" in elements:
        pairs = [whole(column(elements["edge"], name, path, "edge"), path, name) for name in EDGES]
        order, counts = chains(np.stack(pairs, axis=1), len(points), path)
    else:
        right = "an element strand with nsegs, or an element edge with vertex1 and vertex2"
        raise BadInput(f"no strands among the elements {', '.join(elements) or 'of the file'}", where=path, right=right)
    if unread := sorted(vertex.keys() - READ):
        warnings.warn(f"{path}: properties that are not read: {', '.join(unread)}", stacklevel=2)
    widths = column(vertex, "thickness", path, "vertex")[order] if "thickness" in vertex else None
    colours = None
    if vertex.keys() >= set(COLOURS):
        found = np.stack([column(vertex, name, path, "vertex") for name in COLOURS], axis=1)[order]
        bright = np.asarray(vertex["red"]).dtype.kind == "u" or found.max(initial=0.0) > 1.0
        colours = (found / 255.0 if bright else found).astype(np.float32)
    return plain_curves(points[order], counts, unit, up, widths=widths, colours=colours)


def column(element: Columns, name: str, path: Path, owner: str) -> np.ndarray:
    found = element.get(name)
    if found is None or isinstance(found, Lists):
        raise BadInput(f"element {owner} has no number {name}", where=path, right=f"property float {name}")
    return found.astype(np.float64)


def whole(values: np.ndarray, path: Path, name: str) -> np.ndarray:
    """Return values as whole numbers, (n,) int64; BadInput naming the first that is not one."""
    bad = ~(np.abs(values) <= np.iinfo(np.int32).max) | (values != np.rint(values))
    if bad.any():
        row = int(np.argmax(bad))
        raise BadInput(f"{name} of row {row} is {values[row]:g}", where=path, right="a whole number")
    return values.astype(np.int64)


def chains(edges: np.ndarray, count: int, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices of polylines of edges (n, 2), each from its end with the lower index, and their counts."""
    if not len(edges) or edges.min() < 0 or edges.max() >= count:
        what = f"an edge has the vertex {edges.max()}" if len(edges) else "no edges"
        raise BadInput(what, where=path, right=f"vertices 0 to {count - 1}")
    degree = np.bincount(edges.ravel(), minlength=count)
    if degree.max() > 2:
        what = f"{degree.max()} edges meet at vertex {degree.argmax()}"
        raise BadInput(what, where=path, right="at most 2: strands do not branch")
    near = np.full((count, 2), -1, np.int64)
    ends = edges.ravel()
    by_end = np.argsort(ends, kind="stable")
    is_second = np.diff(ends[by_end], prepend=-1) == 0
    near[ends[by_end], is_second.astype(np.int64)] = edges[:, ::-1].ravel()[by_end]
    neighbours = near.tolist()
    used = np.zeros(count, bool)
    order, counts = list[int](), list[int]()
    for end in np.flatnonzero(degree == 1).tolist():
        if used[end]:
            continue
        before = -1
        here = end
        first = len(order)
        while here >= 0:
            order.append(here)
            one, other = neighbours[here]
            before, here = here, other if one == before else one
        used[before] = True
        counts.append(len(order) - first)
    if len(order) < np.count_nonzero(degree):
        closed = np.setdiff1d(np.flatnonzero(degree), order)[0]
        raise BadInput(f"the line through vertex {closed} is closed", where=path, right="open lines")
    return np.array(order), np.array(counts)


NUMBERS = {".data": 3, ".bin": 7}
"""Numbers of a point, by suffix."""


def read_records(path: Path, unit: float = 1.0, up: Up = "y") -> Curves:
    """Return the strands that have points; BadInput, with the byte, where a number contradicts the size of the file."""
    data = content(path, f"a {path.suffix} file")
    words = np.frombuffer(data[: len(data) // 4 * 4] or bytes(4), "<i4")
    width = NUMBERS[path.suffix.lower()]
    strands = int(words[0])
    if not 1 <= strands < len(words):
        right = f"1 to {len(words) - 1}, for a file of {4 * len(words)} bytes"
        raise BadInput(f"{strands} strands", where=f"{path}, byte 0", right=right)
    counts = np.empty(strands, np.int64)
    at = 1
    for s in range(strands):
        count = int(words[at]) if at < len(words) else -1
        left = (len(words) - at - 1) // width
        if not 0 <= count <= left:
            what = f"strand {s} has {count} points" if at < len(words) else f"strand {s} of {strands} is missing"
            right = f"0 to {left}: the file has no more" if left >= 0 else "a whole file"
            raise BadInput(what, where=f"{path}, byte {4 * at}", right=right)
        counts[s] = count
        at += 1 + width * count
    if at < len(words):
        what = f"{4 * (len(words) - at)} bytes follow the last strand"
        raise BadInput(what, where=f"{path}, byte {4 * at}", right="none")
    heads = np.cumsum(1 + width * counts) - width * counts
    numbers = np.delete(words[1:], heads - 1).view("<f4").reshape(-1, width)
    if not counts.all():
        warnings.warn(f"{path}: {(counts == 0).sum()} strands have no points and are left out", stacklevel=2)
    if width > 3:
        warnings.warn(f"{path}: directions and labels are not read", stacklevel=2)
    return plain_curves(numbers[:, :3], counts[counts > 0], unit, up)
