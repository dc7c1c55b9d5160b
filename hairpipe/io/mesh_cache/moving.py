"""An animated mesh at one instant, from the samples around it, which are read one by one."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from hairpipe.data import Mesh
from hairpipe.io.mesh_cache.stencil import stencil_at
from hairpipe.io.polygons import merge_meshes

SLOW, ALIKE = 0.01, 0.5
"""Root mean square of velocities that are not compared [m/s], and largest difference of others, as a share."""


@dataclass(frozen=True)
class Instant:
    """What is read from an animated mesh.

    start       time code of the file, see `Source.rate`
    elapsed     time since then [s]
    cuts        the same of the last frame before each cut, and of the first after it, ascending [s]
    velocities  "file", or "samples": slope of the points
    reference   time code of the sample that gives the triangles; None for the first
    fps         time codes per second of a format without any [1/s]
    speed       factor of the velocities
    """

    start: float
    elapsed: float
    cuts: tuple[tuple[float, float], ...] = ()
    velocities: str = "file"
    reference: float | None = None
    fps: float = 24.0
    speed: float = 1.0


class Shape(NamedTuple):
    """Triangles of a mesh: those of each polygon follow each other.

    mesh    at one sample [m or file units]
    owners  polygon of every triangle, (m,) int64
    """

    mesh: Mesh
    owners: np.ndarray


def join_shapes(shapes: Sequence[Shape]) -> Shape:
    """Return the triangles of several meshes as one."""
    firsts = np.cumsum([0] + [shape.owners.max(initial=-1) + 1 for shape in shapes])
    owners = [shape.owners + first for shape, first in zip(shapes, firsts, strict=False)]
    return Shape(merge_meshes([shape.mesh for shape in shapes]), np.concatenate(owners))


Points = tuple[np.ndarray, np.ndarray | None]
"""Points of a piece [m or file units] and their velocities [1/s], (n, 3) float64 each, None for a piece without any."""


class Source(Protocol):
    """Samples of an animated mesh, which consists of pieces with the same points at all times.

    codes  time codes of the samples, ascending, (t,) float64
    rate   time codes per second [1/s]
    """

    codes: np.ndarray
    rate: float

    @property
    def own(self) -> Sequence[bool]:
        """Whether the samples of each piece have velocities."""
        ...

    def shape(self, sample: int) -> Shape:
        """Read the triangles at a sample, and all points there; BadInput where they are invalid."""
        ...

    def sample(self, sample: int) -> list[Points]:
        """Read the points of the pieces at a sample; BadInput where they are invalid, or polygons have changed."""
        ...


def read_at(source: Source, instant: Instant) -> Shape:
    """Return the mesh at an instant, with velocities: no more samples than one are in memory at a time.

    Warns where velocities of the file are not those of its points.
    """
    reference = 0 if instant.reference is None else int(np.abs(source.codes - instant.reference).argmin())
    shape = source.shape(reference)
    own = [instant.velocities == "file" and has for has in source.own]
    times = source.codes / source.rate
    start = instant.start / source.rate
    at = start + instant.elapsed
    if not times[0] - 1.0 / source.rate < at < times[-1] + 1.0 / source.rate and len(times) > 1:
        ends = f"{source.codes[0]:g} to {source.codes[-1]:g}"
        message = f"the file has the time codes {ends}: outside of them the mesh holds still (see `at` and `start`)"
        warnings.warn(message, stacklevel=2)
    cuts = [(start + before, start + after) for before, after in instant.cuts]
    stencils = {kind: stencil_at(times, at, cuts, kind) for kind in {*own, False}}
    points = np.zeros_like(shape.mesh.points)
    velocities, slopes = np.zeros_like(points), np.zeros_like(points)
    for sample in sorted({int(k) for stencil in stencils.values() for k in stencil.samples}):
        first = 0
        for given, has in zip(source.sample(sample), own, strict=True):
            part = slice(first, first := first + len(given[0]))
            for kind in {has, False}:
                used = stencils[kind].weights[stencils[kind].samples == sample]
                for weights in used:
                    if kind == has:
                        add(points[part], weights[0], given)
                        add(velocities[part], weights[1], given)
                    if kind is False:
                        add(slopes[part], weights[1], given)
    if any(own):
        _compare(velocities, slopes)
    mesh = shape.mesh
    return Shape(Mesh(points, mesh.triangles, instant.speed * velocities, mesh.uv), shape.owners)


def add(sums: np.ndarray, weights: np.ndarray, given: Points) -> None:
    """Add the weighted points and velocities of a sample to sums (n, 3), in place."""
    for weight, values in zip(weights, given, strict=True):
        if weight != 0.0 and values is not None:
            sums += weight * values


def _compare(velocities: np.ndarray, slopes: np.ndarray) -> None:
    """Warn where velocities differ from the slopes of the points, as those in units per frame do."""
    sizes = [np.sqrt(np.square(rates).sum(axis=1).mean()) for rates in (velocities, slopes, velocities - slopes)]
    if max(sizes[:2]) > SLOW and sizes[2] > ALIKE * max(sizes[:2]):
        what = "velocities of the file are not those of its points, which may mean units per frame"
        warnings.warn(f'{what} (velocities = "samples" computes them from the points)', stacklevel=3)
