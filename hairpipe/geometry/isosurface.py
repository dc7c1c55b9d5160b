"""Triangles of the zero set of a field sampled on a rectilinear grid: surface nets."""

import numpy as np

# Gibson, "Constrained elastic surface nets", 1998: one vertex in every cell the surface passes through, one
# quadrilateral around every grid edge it crosses. Triangles come out far more even than those of marching cubes.

Axes = tuple[np.ndarray, np.ndarray, np.ndarray]

CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])  # of a cell; number 4i + 2j + k
EDGES = [(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1]


def extract_surface(values: np.ndarray, axes: Axes) -> tuple[np.ndarray, np.ndarray]:
    """Return points [m] (n, 3) and triangles (m, 3) int32 of the surface values = 0: closed, manifold, outward. Pure.

    values  samples, negative inside and positive on the border of the grid, (nx, ny, nz)
    axes    coordinates of the samples along x, y and z [m], increasing
    """
    values = separate_sheets(values)
    cases = cell_cases(values)
    mixed = (cases > 0) & (cases < 255)
    index = np.full(mixed.shape, -1, np.int64)
    index[mixed] = np.arange(np.count_nonzero(mixed))
    points = _cell_points(values, np.argwhere(mixed), axes)
    quads = np.concatenate([_quads_across(values < 0.0, index, axis) for axis in range(3)])
    return points, split_quads(points, quads)


def split_quads(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Cut every quadrilateral (q, 4) along its shorter diagonal, (2q, 3) int32. Pure."""
    a, b, c, d = quads.T
    first = np.linalg.norm(points[a] - points[c], axis=1) <= np.linalg.norm(points[b] - points[d], axis=1)
    along_ac = np.stack([a, b, c, a, c, d], axis=1)
    along_bd = np.stack([a, b, d, b, c, d], axis=1)
    return np.where(first[:, None], along_ac, along_bd).reshape(-1, 3).astype(np.int32)


def separate_sheets(values: np.ndarray) -> np.ndarray:
    """Return the samples with the least changes of sign after which no cell holds two sheets of the surface. Pure.

    Two sheets would have to share the one vertex of a cell, and the mesh would not be manifold. In such a cell the
    inside corner nearest to the surface is moved outside; as corners only ever go outside, this ends.
    """
    values = values.copy()
    while len(cells := np.argwhere(TWO_SHEETS[cell_cases(values)])):
        corners = cells[:, None, :] + CORNERS
        depths = -values[tuple(np.moveaxis(corners, -1, 0))]
        nearest = np.where(depths > 0.0, depths, np.inf).argmin(axis=1)
        chosen = tuple(corners[np.arange(len(cells)), nearest].T)
        values[chosen] = np.abs(values[chosen])
    return values


def cell_cases(values: np.ndarray) -> np.ndarray:
    """Return which corners of every cell are inside, bit by bit, (nx-1, ny-1, nz-1). Pure."""
    inside = (values < 0.0).astype(np.uint8)
    low, high = slice(None, -1), slice(1, None)
    corners = [inside[tuple(high if o else low for o in corner)] << bit for bit, corner in enumerate(CORNERS)]
    return np.bitwise_or.reduce(corners)


def _holds_two_sheets(case: int) -> bool:
    """Whether inside or outside corners are not joined by edges, or a face has both at its opposite corners."""
    inside = np.array([case >> bit & 1 for bit in range(8)], bool)
    group = np.arange(8)
    for _ in range(8):
        for a, b in EDGES:
            if inside[a] == inside[b]:
                group[a] = group[b] = min(group[a], group[b])
    faces = [CORNERS[:, axis] == side for axis in range(3) for side in (0, 1)]
    crossed = [sum(inside[a] != inside[b] for a, b in EDGES if face[a] and face[b]) for face in faces]
    return len(set(group)) > 2 or max(crossed) > 2


TWO_SHEETS = np.array([_holds_two_sheets(case) for case in range(256)])


def _cell_points(values: np.ndarray, cells: np.ndarray, axes: Axes) -> np.ndarray:
    """Mean of the points where the surface crosses the edges of each cell (c, 3)."""
    total = np.zeros((len(cells), 3))
    count = np.zeros(len(cells))
    for start, end in EDGES:
        a, b = cells + CORNERS[start], cells + CORNERS[end]
        value_a, value_b = values[tuple(a.T)], values[tuple(b.T)]
        crossed = (value_a < 0.0) != (value_b < 0.0)
        share = (value_a[crossed] / (value_a[crossed] - value_b[crossed]))[:, None]
        position_a, position_b = (
            np.stack([x[i] for x, i in zip(axes, p[crossed].T, strict=True)], axis=1) for p in (a, b)
        )
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
