"""Parts of bodies of files: rotations of joints without scale, ends of bones, influences and maps of several meshes."""

from collections.abc import Mapping, Sequence

import numpy as np


def rigid(world: np.ndarray) -> np.ndarray:
    """Return the nearest rotations, and the origins, of affine matrices (J, 4, 4); our joints have no scale. Pure."""
    left, _, right = np.linalg.svd(world[:, :3, :3])
    left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
    result = world.copy()
    result[:, :3, :3] = left @ right
    return result


def find_tips(parents: np.ndarray, origins: np.ndarray) -> np.ndarray:
    """Return the end of every bone, (J, 3): the mean of its children; a leaf continues the bone of its parent."""
    tips = origins.copy()
    for joint, parent in enumerate(parents):
        children = np.flatnonzero(parents == joint)
        if len(children):
            tips[joint] = origins[children].mean(axis=0)
        elif parent >= 0:
            tips[joint] = 2 * origins[joint] - origins[parent]
    return tips


def stack_influences(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Stack joints or weights (n, k) of several meshes, with several widths k, padded with zeros. Pure."""
    width = max(array.shape[1] for array in rows)
    return np.concatenate([np.pad(array, ((0, 0), (0, width - array.shape[1]))) for array in rows])


def merge_maps(maps: Sequence[Mapping[str, np.ndarray]], counts: Sequence[int]) -> dict[str, np.ndarray]:
    """Return every map over the vertices of all meshes, 0 on meshes without it. Pure.

    counts  vertices of each mesh
    """
    names = sorted({name for given in maps for name in given})
    bare = [np.zeros(count) for count in counts]
    return {name: np.concatenate([m.get(name, b) for m, b in zip(maps, bare, strict=True)]) for name in names}
