"""Values as NPZ files, for users who have only numpy; the layout is that of `numpy.savez`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zipfile import ZipFile, ZipInfo

import numpy as np

from hairpipe.io.hdf5 import Tree, take_apart


def write_npz(path: Path, value: Any) -> None:
    """Write every array, number and text of a value under its dotted name; None is omitted.

    The same value gives the same bytes. Raises TypeError for other types.
    """
    with ZipFile(path, "w") as archive:
        for name, array in arrays(take_apart(value)):
            with archive.open(ZipInfo(f"{name}.npy"), "w", force_zip64=True) as file:
                np.lib.format.write_array(file, array, allow_pickle=False)


def arrays(tree: Tree, name: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Walk a tree that `take_apart` gives: dotted names and arrays, numbers and texts as arrays too."""
    if isinstance(tree, dict):
        for key, item in tree.items():
            yield from arrays(item, f"{name}.{key}" if name else key)
    elif isinstance(tree, tuple):
        yield name, np.array(tree, dtype=str)
    elif tree is not None:
        yield name, np.asarray(tree)
