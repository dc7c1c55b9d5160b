"""Error of the surface between two frames."""

from collections.abc import Sequence

import numpy as np

from hairpipe.geometry.collider import Collider, SdfSample
from hairpipe.graphs.experiments.studies.interpolation.bodies import FRAME, outline_at, skin_at, surfaces_of
from hairpipe.graphs.experiments.studies.interpolation.cases import CASES
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

COLUMNS = ("case", "interpolation", "time [frames]", "error max [%]", "error mean [%]", "lost [%]")


def interpolation_table(fractions: Sequence[float], voxel: float, half_width: float) -> Table:
    """Tabulate the distance that points of the true surface have, in percent of the body's radius.

    fractions   times after the first frame [frames]
    voxel       spacing of the samples [m]; the bodies are about 0.6 m large
    half_width  of the band, in voxels

    Rows "baked then" are of a level set that is baked at the very time: nothing but the samples' own error. A point is
    lost where no body is in reach; its error is that of the band's border.
    """
    rows = []
    for case in CASES:
        surfaces = surfaces_of(case, voxel, half_width)
        for a in fractions:
            points = outline_at(case, a)
            still = bake(skin_at(case, a), voxel, half_width)
            floor = {"baked then": build_collider_field(still, still, FRAME, Interpolation.linear)}
            for name, surface in (surfaces | floor).items():
                off, lost = misses(surface, points, a * FRAME, voxel * half_width)
                figures = 100.0 * off.max() / case.radius, 100.0 * off.mean() / case.radius, 100.0 * lost.mean()
                rows.append((case.name, name.replace("_", "-"), a, *figures))
    return table_of_rows(COLUMNS, rows)


def misses(surface: Collider, points: np.ndarray, seconds: float, band: float) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a surface is off points that should be on it [m], (n,), and which it does not reach, (n,) bool.

    band  the farthest it reaches [m]
    """
    probe = SdfSample.blank(len(points))
    surface.probe(points, seconds, probe)
    lost = ~np.isfinite(probe.distance)
    return np.abs(np.where(lost, band, probe.distance)), lost
