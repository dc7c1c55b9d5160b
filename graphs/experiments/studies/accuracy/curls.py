"""A strand that is an arc by nature and hangs from its root: where it leaves its plane, and its helix beyond.

Strands hang along +Y. Weights are rho A g L^3 / (EI), curvatures are those of the arc times L, the sum of the segments.
A strand becomes a helix of one hand on the way from a natural helix to an arc.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.accuracy.helix import rod_of
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Pose, Specimen, specimen_of
from hairpipe.graphs.experiments.studies.accuracy.statics import Balance, balance, least_stiffness, motions
from hairpipe.graphs.experiments.studies.theory.clamps import Clamp, hang_rod
from hairpipe.graphs.experiments.studies.theory.hanging_curls import (
    helix_height,
    leaving_curvature,
    leaving_weight,
    local_helix,
)
from hairpipe.graphs.experiments.studies.theory.kirchhoff import Rod
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

_HALVINGS = 10
_BELOW, _ABOVE = 0.75, 1.25
"""Range of a measured threshold over that of the theory."""
_APPROACH = 4
"""Steps of the continuation up to that range."""
_TILTS = (0.5, 0.2, 0.08, 0.03, 0.01)
"""Pitches of natural helices over their circumference, on the way to an arc."""
_FINE = 400
"""Segments of the strand that a rod is."""
_PLANAR = 1e-3
"""Largest distance from the plane of a planar strand, over its length."""
_INCLINED = 0.9
"""Cosine between strand and vertical below which a part of it counts as curled."""
THRESHOLDS = ("strand", "segments", "curvature", "weight", "theory", "error [%]")
HEIGHTS = ("strand", "segments", "curvature", "weight", "theory", "slow helix", "measured", "error [% of length]")
PITCHES = (
    "strand",
    "segments",
    "arc from the tip [% of length]",
    "pitch [% of length]",
    "theory",
    "error [%]",
    "middle half",
)
BORDERS = ("kind", "curvature", "weight")
SHAPES = ("strand", "curvature", "weight", "shape", "off the plane [% of length]", "curled [% of length]", "theory")


def hook_table(sample: Sample, segments: Sequence[int], weights: Sequence[float]) -> Table:
    """Tabulate the natural curvature at which a planar hook becomes unstable out of its plane."""
    rows = []
    for weight in weights:
        theory = leaving_curvature(weight, ratio_of(sample))
        for count in segments:
            found = threshold(theory, lambda k, w=weight, n=count: (curled(sample, n, k), w))
            rows.append((sample.name(count), count, found, weight, theory, 100 * (found / theory - 1)))
    return table_of_rows(THRESHOLDS, rows)


def coil_table(sample: Sample, segments: Sequence[int], curvatures: Sequence[float]) -> Table:
    """Tabulate the weight at which a planar coil becomes unstable out of its plane."""
    rows = []
    for curvature in curvatures:
        theory = leaving_weight(curvature, ratio_of(sample))
        for count in segments:
            coil = curled(sample, count, curvature)
            found = threshold(theory, lambda w, strand=coil: (strand, w))
            rows.append((sample.name(count), count, curvature, found, theory, 100 * (found / theory - 1)))
    return table_of_rows(THRESHOLDS, rows)


def height_table(sample: Sample, segments: Sequence[int], curvature: float, weight: float) -> Table:
    """Tabulate the height of a hanging helix, over the length, against Kirchhoff's rod and a slowly varying helix."""
    shape = None
    for rod, clamp in helix_rods(sample, curvature, weight):
        shape = hang_rod(rod, clamp, guess=shape)
    assert shape is not None
    theory = shape.points[-1, 1] / sample.length
    slow = helix_height(curvature, weight, ratio_of(sample))
    rows = []
    for count in segments:
        strand, at = hanging_helix(sample, count, curvature, weight)
        found = float(at.pose.x[strand.tip, 1]) / sample.length if at.found else np.nan
        rows.append((sample.name(count), count, curvature, weight, theory, slow, found, 100 * (found - theory)))
    return table_of_rows(HEIGHTS, rows)


def pitch_table(sample: Sample, segments: Sequence[int], curvature: float, weight: float) -> Table:
    """Tabulate the pitch along a hanging helix, over the length, a mean over a turn, against that of the tension."""
    rows = []
    for count in segments:
        strand, at = hanging_helix(sample, count, curvature, weight)
        points = strand.axis(at.pose) / sample.length
        edges = np.diff(points, axis=0)
        azimuth = np.unwrap(np.arctan2(edges[:, 2], edges[:, 0]))
        hand = np.sign(azimuth[-1] - azimuth[0])
        turned = np.maximum.accumulate(hand * (azimuth - azimuth[0])) / (2 * np.pi)
        middles = (points[1:, 1] + points[:-1, 1]) / 2
        arc = (np.arange(count) + 0.5) / count
        for turn in np.arange(1.0, turned[-1] - 1.0):
            above, below = np.interp([turn - 0.5, turn + 0.5], turned, middles)
            place = 1 - float(np.interp(turn, turned, arc))
            cosine, rate = local_helix(np.array([weight * place]), curvature, ratio_of(sample))
            theory = float(2 * np.pi * cosine[0] / rate[0]) if rate[0] > 0.0 else np.nan
            pitch = below - above
            row = (100 * place, 100 * pitch, 100 * theory, 100 * (pitch / theory - 1), float(0.25 < place < 0.75))
            rows.append((sample.name(count), count, *row))
    return table_of_rows(PITCHES, rows)


def border_table(sample: Sample, hooks: Sequence[float], coils: Sequence[float]) -> Table:
    """Tabulate the border of planar shapes by theory: hooks of these weights, and coils of these curvatures."""
    ratio = ratio_of(sample)
    rows = [("hook", leaving_curvature(weight, ratio), weight) for weight in hooks]
    rows += [("coil", curvature, leaving_weight(curvature, ratio)) for curvature in coils]
    return table_of_rows(BORDERS, rows)


def shape_table(sample: Sample, count: int, curvatures: Sequence[float], weights: Sequence[float]) -> Table:
    """Tabulate the shape of strands that hang: planar, or a helix and its part of the length.

    The theory is that part of a slowly varying helix.
    """
    rows = []
    for curvature in curvatures:
        for weight in weights:
            strand, at = hanging_helix(sample, count, curvature, weight)
            points = strand.axis(at.pose) / sample.length
            level = points[:, [0, 2]] - points[0, [0, 2]]
            aside = 2 * float(np.linalg.svd(level)[1][-1]) / np.sqrt(len(level))
            edges = np.diff(points, axis=0) * count
            inclined = 100 * float(np.mean(smoothed(edges[:, 1], curvature) < _INCLINED))
            places = (np.arange(1000) + 0.5) / 1000
            cosine = local_helix(weight * places, curvature, ratio_of(sample))[0]
            curl = "planar" if aside < _PLANAR else "helix"
            shape = curl if at.found else "not at rest"
            theory = 100 * float(np.mean(cosine < _INCLINED))
            rows.append((sample.name(count), curvature, weight, shape, 100 * aside, inclined, theory))
    return table_of_rows(SHAPES, rows)


def ratio_of(sample: Sample) -> float:
    """GJ / EI of the material."""
    return sample.material.torsion / sample.material.bending


def threshold(theory: float, case: Callable[[float], tuple[Specimen, float]]) -> float:
    """Bisect a parameter for the place where a strand, followed from small parameters on, has no stiffness left.

    case  strand and weight of a parameter
    NaN where there is none near the theory.
    """
    low = _BELOW * theory
    pose = None
    for part in np.arange(1, _APPROACH) / _APPROACH:
        pose, _ = planar(*case(part * low), pose)
    pose, stable = planar(*case(low), pose)
    high = _ABOVE * theory
    if not stable or planar(*case(high), pose)[1]:
        return np.nan
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        pose, stable = planar(*case(middle), pose)
        low, high = (middle, high) if stable else (low, middle)
    return (low + high) / 2


def planar(strand: Specimen, weight: float, pose: Pose | None) -> tuple[Pose, bool]:
    """Balance a planar strand from a pose, or from rest, and find whether it is stable."""
    at = hung(strand, weight, pose or strand.rest)
    return at.pose, at.found and least_stiffness(strand, at.pose, motions(strand)) > 0.0


def hanging_helix(sample: Sample, count: int, curvature: float, weight: float) -> tuple[Specimen, Balance]:
    """Return a strand with the natural shape of an arc, and its equilibrium, a helix of one hand if it may."""
    pose = None
    for tilt in _TILTS:
        strand = curled(sample, count, curvature, tilt)
        pose = hung(strand, weight, pose or strand.rest).pose
    strand = curled(sample, count, curvature)
    return strand, hung(strand, weight, pose or strand.rest)


def helix_rods(sample: Sample, curvature: float, weight: float) -> Iterator[tuple[Rod, Clamp]]:
    """Return the rods that strands of all tilts are, in order, and their clamps."""
    for tilt in (*_TILTS, 0.0):
        curl = natural(sample, curvature, tilt)
        rod, clamp = rod_of(sample, curl, wound(curl, sample.length, _FINE))
        load = weight * sample.material.bending / sample.length**3
        yield replace(rod, weight=np.array([0.0, load, 0.0])), Clamp(clamp.point, upright(tilt) @ clamp.frame)


def natural(sample: Sample, curvature: float, tilt: float) -> Helix:
    """Return a helix of a curvature; tilt  pitch over circumference."""
    radius = sample.length / curvature / (1 + tilt**2)
    return Helix(radius, 2 * np.pi * radius * tilt)


def upright(tilt: float) -> np.ndarray:
    """Return the rotation that takes the tangent of a helix at its root to +Y, (3, 3)."""
    size = np.hypot(1.0, tilt)
    return np.array([[size, 0.0, 0.0], [0.0, 1.0, tilt], [0.0, -tilt, 1.0]]) / size


def curled(sample: Sample, count: int, curvature: float, tilt: float = 0.0) -> Specimen:
    """Make a strand of a natural curvature whose root is along +Y; tilt  as of `natural`."""
    return specimen_of(sample, wound(natural(sample, curvature, tilt), sample.length, count) @ upright(tilt).T)


def hung(strand: Specimen, weight: float, pose: Pose) -> Balance:
    """Balance a strand of a weight from a pose of its free rows."""
    length = strand.segment * strand.segments
    held = strand.shape.clamped
    pose = Pose(np.concatenate([strand.rest.x[:held], pose.x[held:]]), pose.T)
    gravity = weight * strand.material.bending / (strand.material.line_density * length**3)
    return balance(strand, pose, strand.weight(np.array([0.0, gravity, 0.0])), motions(strand))


def smoothed(values: np.ndarray, curvature: float) -> np.ndarray:
    """Return means over a natural turn, of which strands have `curvature` / 2 pi."""
    width = max(1, round(2 * np.pi / curvature * len(values)))
    return values if width >= len(values) else np.convolve(values, np.ones(width) / width, "same")
