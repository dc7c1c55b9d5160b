"""A posed body between keys: the surface by every interpolation against the skin at the very time.

Every n-th frame of a clip is a key; the frames between are the reference, and are not given to the interpolations.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider
from hairpipe.graphs.experiments.studies.interpolation.surface_errors import misses
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import BodyParts, LevelSet, Mesh, Table
from hairpipe.values.table import table_of_rows
from hairpipe.values.triangles import Sites, area_vectors, site_points

COLUMNS = ("interpolation", "time [keys]", "error mean [mm]", "error 99 % [mm]", "error max [mm]", "lost [%]")
POINTS = 8000
"""On the skin, one for every so-much of its area at rest."""
OUTER = 0.5
"""Voxels from the surface that is baked: a point farther off is on a sheet within the body."""
# Steps of the R2 sequence (Roberts 2018): points that are spread over a square without chance.
SPREAD = np.array([0.7548776662466927, 0.5698402909980532])


class Clip(NamedTuple):
    """A body at all frames, by number, each read on demand."""

    skins: Mapping[int, Mesh]
    surfaces: Mapping[int, LevelSet]
    parts: Mapping[int, BodyParts]


def clip_table(rest: Mesh, clip: Clip, stride: int, dt: float) -> Table:
    """Tabulate the distance that points of the true skin have, for every time between two keys.

    rest    the skin at rest: what is hidden there, such as the mouth, is hidden all through
    stride  frames from one key to the next, of those that there are; fewer where there are fewer frames
    dt      time between frames [s]

    Time is counted in keys. "baked then" is a level set baked at the very time: nothing but the samples' own error.
    Raise BadInput where the body is not the one at rest.
    """
    numbers = list(clip.skins)
    if not np.array_equal(clip.skins[numbers[0]].triangles, rest.triangles):
        raise BadInput("the triangles are not those of in.rest", where="in.body", right="in.rest, posed")
    stride = max(1, min(stride, len(numbers) - 1))
    found: dict[tuple[str, float], list[tuple[np.ndarray, np.ndarray]]] = {}
    sites = outer_sites(rest, clip.surfaces[numbers[0]])
    for begin in range(0, len(numbers) - stride, stride):
        first = numbers[begin]
        last = numbers[begin + stride]
        seconds = (last - first) * dt
        surfaces = surfaces_between(clip, first, last, seconds)
        for number in numbers[begin : begin + stride + 1]:
            then = clip.surfaces[number]
            a = (number - first) / (last - first)
            points = site_points(clip.skins[number], sites)
            baked = build_collider_field(then, then, 1.0, Interpolation.linear)
            near = misses(baked, points, 0.0, np.inf)[0] < OUTER * then.voxel
            for name, surface in (surfaces | {"baked then": baked}).items():
                band = then.voxel * then.half_width
                off = misses(surface, points[near], a * seconds, band)
                found.setdefault((name, a), []).append(off)
    return table_of_rows(
        COLUMNS, [row(*key, *map(np.concatenate, zip(*offs, strict=True))) for key, offs in found.items()]
    )


def row(name: str, a: float, off: np.ndarray, lost: np.ndarray) -> tuple[str, float, float, float, float, float]:
    """Return a row of the table."""
    off = 1e3 * off
    return name.replace("_", "-"), a, off.mean(), float(np.percentile(off, 99)), off.max(), 100.0 * lost.mean()


def surfaces_between(clip: Clip, first: int, last: int, seconds: float) -> dict[str, Collider]:
    """Return the body between two keys by every interpolation, by name."""
    whole, parts = (clip.surfaces[first], clip.surfaces[last]), (clip.parts[first], clip.parts[last])
    found: dict[str, Collider] = {
        name: build_collider_field(*whole, seconds, Interpolation[name])
        for name in ("linear", "one_sided", "two_sided")
    }
    return found | {"parts": build_collider_parts(*parts, seconds)}


def outer_sites(rest: Mesh, like: LevelSet) -> Sites:
    """Return places spread evenly over a skin where it is the outside of the body, by a level set with like voxels."""
    areas = np.linalg.norm(area_vectors(rest), axis=1)
    steps = np.arange(POINTS) + 0.5
    triangles = np.searchsorted(np.cumsum(areas), steps * areas.sum() / POINTS)
    u, v = (steps[:, None] * SPREAD % 1.0).T
    root = np.sqrt(u)
    sites = Sites(triangles.astype(np.int32), np.stack([1.0 - root, root * (1.0 - v), root * v], axis=1))
    still = bake(rest, like.voxel, like.half_width)
    surface = build_collider_field(still, still, 1.0, Interpolation.linear)
    outer = misses(surface, site_points(rest, sites), 0.0, np.inf)[0] < OUTER * like.voxel
    return Sites(sites.triangles[outer], sites.barycentrics[outer])
