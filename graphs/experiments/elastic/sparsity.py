"""The sparse matrix of a mesh: 3 x 3 blocks by rows, with a place for every pair of particles that is coupled."""

from typing import NamedTuple

import numpy as np
from numba import njit


class Pattern(NamedTuple):
    """Where the blocks of a matrix are.

    first     blocks of row i are first[i]:first[i+1], (n+1,) int32
    column    of every block, ascending within a row, (blocks,) int32
    diagonal  block on the diagonal of every row, (n,) int32
    by_pair   blocks (p, p), (p, q), (q, p), (q, q) of every linear spring, (e, 4) int32
    by_four   blocks of every altitude spring, row by row, (t, 16) int32
    """

    first: np.ndarray
    column: np.ndarray
    diagonal: np.ndarray
    by_pair: np.ndarray
    by_four: np.ndarray


def find_pattern(count: int, pairs: np.ndarray, fours: np.ndarray) -> Pattern:
    """Find the blocks that springs couple.

    count  of the particles; pairs  (e, 2); fours  (t, 4)
    """
    here = np.arange(count, dtype=np.int64) * (count + 1)
    keys = [_keys(count, pairs), _keys(count, fours)]
    unique = np.unique(np.concatenate([here, *(key.ravel() for key in keys)]))
    row, column = np.divmod(unique, count)
    first = np.searchsorted(row, np.arange(count + 1))
    places = [np.searchsorted(unique, key).astype(np.int32) for key in (here, *keys)]
    return Pattern(first.astype(np.int32), column.astype(np.int32), *places)


def _keys(count: int, groups: np.ndarray) -> np.ndarray:
    groups = groups.astype(np.int64)
    return (groups[:, :, None] * count + groups[:, None, :]).reshape(len(groups), -1)


@njit(cache=True)
def multiply(y: np.ndarray, first: np.ndarray, column: np.ndarray, A: np.ndarray, x: np.ndarray) -> None:
    """Set y to A x, in place.

    A  blocks (blocks, 3, 3); x, y  (n, 3)
    """
    for i in range(len(first) - 1):
        a, b, c = 0.0, 0.0, 0.0
        for s in range(first[i], first[i + 1]):
            j = column[s]
            u, v, w = x[j, 0], x[j, 1], x[j, 2]
            a += A[s, 0, 0] * u + A[s, 0, 1] * v + A[s, 0, 2] * w
            b += A[s, 1, 0] * u + A[s, 1, 1] * v + A[s, 1, 2] * w
            c += A[s, 2, 0] * u + A[s, 2, 1] * v + A[s, 2, 2] * w
        y[i, 0], y[i, 1], y[i, 2] = a, b, c
