"""Triangles of the zero set of a field sampled on a rectilinear grid: surface nets."""

import numpy as np

# Gibson, "Constrained elastic surface nets", 1998: one vertex in every cell the surface passes through, one
# quadrilateral around every grid edge it crosses. Triangles come out far more even than those of marching cubes. Where
# two sheets pass through one cell they share its vertex: the grid has to be finer than the gaps.

Axes = tuple[np.ndarray, np.ndarray, np.ndarray]


def extract_surface(
    values: np.ndarray, axes: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return points [m] (n, 3) and outward triangles (m, 3) int32 of the surface values = 0. Pure.

    values  samples, negative inside and positive on the border of the grid, (nx, ny, nz)
    axes    coordinates of the samples along x, y and z [m], increasing
    """
    inside = values < 0.0
    corners = [inside[_cell(offset)] for offset in _CORNERS]
    mixed = np.logical_or.reduce(corners) & ~np.logical_and.reduce(corners)
    index = np.full(mixed.shape, -1, np.int64)
    index[mixed] = np.arange(np.count_nonzero(mixed))
    points = _cell_points(values, inside, np.argwhere(mixed), axes)
    quads = np.concatenate([_quads_across(inside, index, axis) for axis in range(3)])
    return points, split_quads(points, quads)


def split_quads(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Cut every quadrilateral (q, 4) along its shorter diagonal, (2q, 3) int32. Pure."""
    a, b, c, d = quads.T
    first = np.linalg.norm(points[a] - points[c], axis=1) <= np.linalg.norm(points[b] - points[d], axis=1)
    along_ac = np.stack([a, b, c, a, c, d], axis=1)
    along_bd = np.stack([a, b, d, b, c, d], axis=1)
    return np.where(first[:, None], along_ac, along_bd).reshape(-1, 3).astype(np.int32)


_CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
_EDGES = [(a, b) for a in _CORNERS for b in _CORNERS if a < b and sum(np.abs(np.subtract(a, b))) == 1]


def _cell(offset: tuple[int, int, int]) -> tuple[slice, ...]:
    """Slices of the sample array that give one corner of every cell."""
    return tuple(slice(o, o - 1 if o == 0 else None) for o in offset)


def _cell_points(values: np.ndarray, inside: np.ndarray, cells: np.ndarray, axes: Axes) -> np.ndarray:
    """Mean of the points where the surface crosses the edges of each cell (c, 3)."""
    total, count = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for start, end in _EDGES:
        a, b = cells + start, cells + end
        crossed = inside[tuple(a.T)] != inside[tuple(b.T)]
        a, b = a[crossed], b[crossed]
        value_a, value_b = values[tuple(a.T)], values[tuple(b.T)]
        share = (value_a / (value_a - value_b))[:, None]
        position_a = np.stack([axes[i][a[:, i]] for i in range(3)], axis=1)
        position_b = np.stack([axes[i][b[:, i]] for i in range(3)], axis=1)
        total[crossed] += position_a + share * (position_b - position_a)
        count[crossed] += 1.0
    return total / count[:, None]


def _quads_across(inside: np.ndarray, index: np.ndarray, axis: int) -> np.ndarray:
    """Quadrilaterals around the crossed grid edges along `axis`: the four cells about each, (q, 4)."""
    lower = inside.take(range(inside.shape[axis] - 1), axis)
    upper = inside.take(range(1, inside.shape[axis]), axis)
    edges = np.argwhere(lower != upper)
    second, third = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
    ring = [index[tuple((edges - shift).T)] for shift in (second + third, third, 0 * third, second)]
    leaving = lower[tuple(edges.T)]  # the field grows along the edge: its direction points outward
    return np.where(leaving[:, None], np.stack(ring, axis=1), np.stack(ring[::-1], axis=1))
