"""Tiles of an image after the UDIM convention: `name.<UDIM>.png` stands for `name.1001.png` and so on.

The tile at texture coordinates (u, v) has the number 1001 + floor(u) + 10 floor(v), floor(u) < 10.
"""

import re
from pathlib import Path

import numpy as np

from hairpipe.errors import BadInput

MARK = "<UDIM>"
COLUMNS = 10
FIRST = 1001
EDGE = 1e-5
"""Width of the left and lower edge of a tile that counts as the neighbour where there is no such tile."""


def list_tiles(path: Path) -> dict[str, Path]:
    """Return the files of an image by the numbers of the tiles; one alone has none. BadInput where there are none."""
    before, mark, after = path.name.partition(MARK)
    if not mark:
        return {"": path}
    form = re.compile(rf"{re.escape(before)}([1-9]\d{{3}}){re.escape(after)}")
    try:
        names = sorted(file.name for file in path.parent.iterdir())
    except OSError:
        names = []
    found = {match[1]: path.with_name(name) for name in names if (match := form.fullmatch(name))}
    if not found:
        raise BadInput("there are no tiles", where=path, right=path.name.replace(MARK, str(FIRST)))
    return found


def tiles_at(uv: np.ndarray, known: set[int], where: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of the tile at texture coordinates (k, 2), (k,), and the coordinates in that tile, (k, 2).

    known  numbers of the tiles that there are

    Raises BadInput naming the tile that is missing, or coordinates without a tile.
    """
    cells = np.floor(uv)
    numbers = _numbers(cells)
    on_edge = uv - cells < EDGE
    for axes in ([0], [1], [0, 1]):
        lacking = ~np.isin(numbers, list(known)) & on_edge[:, axes].all(axis=1)
        back = np.floor(uv)
        back[:, axes] -= 1.0
        better = lacking & np.isin(_numbers(back), list(known))
        cells[better] = back[better]
        numbers = _numbers(cells)
    wrong = (cells < 0.0).any(axis=1) | (cells[:, 0] >= COLUMNS)
    if wrong.any():
        u, v = uv[wrong][0]
        what = f"texture coordinates ({u:.3g}, {v:.3g}) of a root are in no tile"
        raise BadInput(what, where=where, right=f"0 to {COLUMNS} along u, 0 or more along v")
    missing = ~np.isin(numbers, list(known))
    if missing.any():
        what = f"tile {numbers[missing].min()} is missing, with {np.count_nonzero(missing)} roots"
        raise BadInput(what, where=where, right=f"a file of that number, next to {min(known)}")
    return numbers, uv - cells


def _numbers(cells: np.ndarray) -> np.ndarray:
    return (FIRST + cells[:, 0] + COLUMNS * cells[:, 1]).astype(int)
