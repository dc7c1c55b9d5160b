"""Buffer of fragments for every pixel of a tile, sorted by depth.

A pixel keeps its last KEPT fragments sorted (a k-buffer, Bavoil et al. 2007). For a further fragment, the nearest is
blended: lines are drawn nearly from front to back, so that nearer fragments do not follow.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

KEPT = 8
"""Fragments that a pixel keeps, a power of two."""
OPAQUE = 0.004
"""Transmittance below which nothing behind is drawn: a level of 8 bits."""
BLOCK = 8
"""Pixels across a block: lines behind all of its pixels are skipped at once."""
SKIN = 0.002
"""Depth below the skin over which hair fades [m]: roots lie on the mesh, hair rests on a coarser level set."""


class Tile(NamedTuple):
    """Pixels of a part of the film, (rows, columns).

    kept     rings of fragments: depth [m], cover, linear red, green and blue, (rows, columns, KEPT, 5) float32
    head     place of the nearest in its ring, (rows, columns) int32
    filled   number of kept fragments, (rows, columns) int32
    blended  light and transmittance of blended fragments, (rows, columns, 4) float32
    through  transmittance of blended and kept fragments, (rows, columns) float32
    sunk     depth at which hair is invisible below the skin [m], (rows, columns) float32
    limit    depth at which everything is invisible, also behind opaque hair [m], (rows, columns) float32
    far      greatest limit in every block, (rows/BLOCK, columns/BLOCK) float32
    """

    kept: np.ndarray
    head: np.ndarray
    filled: np.ndarray
    blended: np.ndarray
    through: np.ndarray
    sunk: np.ndarray
    limit: np.ndarray
    far: np.ndarray


@njit(cache=True, nogil=True)
def make_tile(depth: np.ndarray) -> Tile:
    """Make an empty tile before a body, infinitely far where there is none [m], (rows, columns)."""
    rows, columns = depth.shape
    limit = np.empty((rows, columns), np.float32)
    blended = np.zeros((rows, columns, 4), np.float32)
    for i in range(rows):
        for j in range(columns):
            limit[i, j] = depth[i, j] + SKIN
            blended[i, j, 3] = 1.0
    kept = np.empty((rows, columns, KEPT, 5), np.float32)
    head = np.zeros((rows, columns), np.int32)
    return Tile(
        kept,
        head,
        np.zeros((rows, columns), np.int32),
        blended,
        np.ones_like(limit),
        limit,
        limit.copy(),
        farthest(limit),
    )


@njit(cache=True, nogil=True)
def farthest(limit: np.ndarray) -> np.ndarray:
    """Return the greatest limit in every block of pixels, (rows/BLOCK, columns/BLOCK) float32."""
    rows, columns = limit.shape
    far = np.zeros(((rows + BLOCK - 1) // BLOCK, (columns + BLOCK - 1) // BLOCK), np.float32)
    for i in range(rows):
        for j in range(columns):
            far[i // BLOCK, j // BLOCK] = max(far[i // BLOCK, j // BLOCK], limit[i, j])
    return far


@njit(cache=True, nogil=True)
def add_fragment(tile: Tile, i: int, j: int, z: float, cover: float, red: float, green: float, blue: float) -> None:
    """Add the cover of a line to pixel (i, j), in front of its limit, in place."""
    kept = tile.kept
    head = tile.head[i, j]
    count = tile.filled[i, j]
    cover *= min(1.0, (tile.sunk[i, j] - z) / SKIN)
    if count == KEPT:
        if z < kept[i, j, head, 0]:  # Nearer than all kept fragments: blended itself in place of the nearest.
            blend(tile, i, j, cover, red, green, blue)
            tile.through[i, j] *= 1.0 - cover
            return
        blend(tile, i, j, kept[i, j, head, 1], kept[i, j, head, 2], kept[i, j, head, 3], kept[i, j, head, 4])
        head = (head + 1) & (KEPT - 1)
        count = count - 1
        tile.head[i, j] = head
    place = count
    while place > 0 and kept[i, j, (head + place - 1) & (KEPT - 1), 0] > z:
        for c in range(5):
            kept[i, j, (head + place) & (KEPT - 1), c] = kept[i, j, (head + place - 1) & (KEPT - 1), c]
        place -= 1
    slot = (head + place) & (KEPT - 1)
    kept[i, j, slot, 0], kept[i, j, slot, 1] = z, cover
    kept[i, j, slot, 2], kept[i, j, slot, 3], kept[i, j, slot, 4] = red, green, blue
    tile.filled[i, j] = count + 1
    tile.through[i, j] *= 1.0 - cover
    if tile.through[i, j] < OPAQUE:
        last = kept[i, j, (head + count) & (KEPT - 1), 0]
        if last < tile.limit[i, j]:
            hide(tile, i, j, last)


@njit(cache=True, nogil=True, inline="always")
def blend(tile: Tile, i: int, j: int, cover: float, red: float, green: float, blue: float) -> None:
    """Blend a fragment behind those already blended, in place."""
    share = tile.blended[i, j, 3] * cover
    tile.blended[i, j, 0] += share * red
    tile.blended[i, j, 1] += share * green
    tile.blended[i, j, 2] += share * blue
    tile.blended[i, j, 3] -= share


@njit(cache=True, nogil=True)
def hide(tile: Tile, i: int, j: int, limit: float) -> None:
    """Set the limit of pixel (i, j) to a depth, in place."""
    top, left = i - i % BLOCK, j - j % BLOCK
    before, tile.limit[i, j] = tile.limit[i, j], limit
    if before < tile.far[i // BLOCK, j // BLOCK]:  # Another pixel sets the limit of the block.
        return
    farthest = np.float32(0.0)
    for a in range(top, min(top + BLOCK, tile.limit.shape[0])):
        for b in range(left, min(left + BLOCK, tile.limit.shape[1])):
            farthest = max(farthest, tile.limit[a, b])
            if farthest == before:  # Another pixel is as far: the limit of the block is unchanged.
                return
    tile.far[i // BLOCK, j // BLOCK] = farthest


@njit(cache=True, nogil=True)
def develop_tile(film: np.ndarray, tile: Tile) -> None:
    """Blend all fragments over this part of the film, (rows, columns, 3), in place; the tile cannot be used again."""
    rows, columns = tile.filled.shape
    for i in range(rows):
        for j in range(columns):
            for n in range(tile.filled[i, j]):
                _, cover, red, green, blue = tile.kept[i, j, (tile.head[i, j] + n) & (KEPT - 1)]
                blend(tile, i, j, cover, red, green, blue)
            for c in range(3):
                film[i, j, c] = film[i, j, c] * tile.blended[i, j, 3] + tile.blended[i, j, c]
