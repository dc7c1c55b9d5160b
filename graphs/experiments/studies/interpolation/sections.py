"""Sections through a body between two frames, under every interpolation."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider, SdfSample
from hairpipe.graphs.experiments.studies.interpolation.bodies import FRAME, outline_at, parts_of, surfaces_of
from hairpipe.graphs.experiments.studies.interpolation.cases import CASES
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_parts import build_collider_parts

ACROSS = 241
"""Points along the longer side of a section."""


class Sections(NamedTuple):
    """Distances in the plane z = 0 [m], (height, width) each, +inf out of reach.

    extent  left, right, bottom and top of the plane [m]
    shown   by name of the interpolation, at every time
    truth   at every time: the solids, each baked on its own, where they are then
    """

    extent: tuple[float, float, float, float]
    shown: dict[str, list[np.ndarray]]
    truth: list[np.ndarray]


def sections(name: str, fractions: Sequence[float], voxel: float, half_width: float) -> Sections:
    """Cut through the body of one of the cases at some times [frames]; BadInput where there is no such case."""
    known = {case.name: case for case in CASES}
    if name not in known:
        raise BadInput(f"no case '{name}'", where="case", right=", ".join(known))
    case = known[name]
    ends = np.concatenate([outline_at(case, a) for a in (0.0, 0.5, 1.0)])
    low = ends.min(axis=0) - 4.0 * voxel
    high = ends.max(axis=0) + 4.0 * voxel
    step = (high - low)[:2].max() / (ACROSS - 1)
    x, y = np.arange(low[0], high[0], step), np.arange(low[1], high[1], step)
    plane = np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=-1)
    shown = {
        key: [distances(surface, plane, a * FRAME) for a in fractions]
        for key, surface in surfaces_of(case, voxel, half_width).items()
    }
    shapes = [bake(solid.mesh(), voxel, half_width) for solid in case.solids]
    then = [parts_of(case, shapes, a) for a in fractions]
    truth = [distances(build_collider_parts(parts, parts, FRAME), plane, 0.0) for parts in then]
    return Sections((x[0], x[-1], y[0], y[-1]), shown, truth)


def distances(surface: Collider, plane: np.ndarray, seconds: float) -> np.ndarray:
    """Return the distances of points [m], (h, w, 3), (h, w)."""
    probe = SdfSample.blank(plane.shape[0] * plane.shape[1])
    surface.probe(plane.reshape(-1, 3), seconds, probe)
    return probe.distance.reshape(plane.shape[:2])
