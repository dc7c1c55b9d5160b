"""An animated mesh at one instant, from the samples around it, which are read one by one."""

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from hairpipe.data import Mesh
from hairpipe.io.mesh_cache.stencil import stencil_at
from hairpipe.io.polygons import merge_meshes

AT = 1001
"""Frame of the shot at which a file begins, or the first of a later shot, where its own times are before the shot."""
ROUNDED = 1e-3
"""Difference of a number of samples per frame from a whole one, or from a whole number of frames per sample."""
SLOW, ALIKE = 0.01, 0.5
"""Root mean square of velocities that are not compared [m/s], and largest difference of others, as a share."""


@dataclass(frozen=True)
class Instant:
    """What is read from an animated mesh.

    start       time code of the file at the frame `at`, see `Source.rate`; None for that of `place`
    elapsed     time since then [s]
    cuts        the same of the last frame before each cut, and of the first after it, ascending [s]
    at          a frame of the shot
    first       first frame of the shot; None for a first sample that belongs at the frame `at`
    velocities  "file", or "samples": slope of the points
    reference   time code of the sample that gives the triangles; None for the first
    fps         frames of the shot per second [1/s]
    speed       factor of the velocities
    """

    start: float | None
    elapsed: float
    cuts: tuple[tuple[float, float], ...] = ()
    at: int = AT
    first: int | None = None
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


def sampled(groups: Iterable[Sequence[float]]) -> set[float]:
    """Return the times of all properties that vary: one with a single sample is constant, whatever its time. Pure."""
    given = [set(times) for times in groups]
    return set().union(*(times for times in given if len(times) > 1))


def place(codes: np.ndarray, rate: float, instant: Instant) -> float:
    """Return the time code that belongs at the frame `at`, the rule of all formats; pure.

    Times are those of the file where it reaches the shot, else it begins at the frame AT, or at the first of a later
    shot. With a frame `at` of the user it begins there.

    codes, rate  time codes of a file, ascending, (t,), and their number per second
    """
    if instant.start is not None:
        return instant.start
    ahead = 0
    if instant.first is not None:
        if len(codes) == 1 or frames_of(codes, rate, instant, instant.at)[1] >= instant.first:
            return float(instant.at)
        ahead = max(instant.first - instant.at, 0)
    return float(codes[0] - ahead / instant.fps * instant.speed * rate)


def frames_of(codes: np.ndarray, rate: float, instant: Instant, start: float) -> tuple[float, float]:
    """Return the frames of the shot that show the first and last time code, if `start` belongs at `at`; pure."""
    first, last = (instant.at + (float(code) - start) / rate * instant.fps / instant.speed for code in codes[[0, -1]])
    return first, last


def _warn_of_times(
    codes: np.ndarray, rate: float, instant: Instant, start: float, written: Callable[[float], float]
) -> None:
    """Warn where times of file and shot do not meet, with the settings that make them meet.

    written  value of the setting `start` for a time code
    """
    first, last = (f"{round(frame, 2):g}" for frame in frames_of(codes, rate, instant, start))
    gaps = np.diff(codes) / rate
    apart = float(np.median(gaps))
    gap = f"1/{1.0 / apart:.5g} s" if apart < 1.0 else f"{apart:.5g} s"
    what = f"the file has {len(codes)} samples, {gap} apart (time codes {codes[0]:g} to {codes[-1]:g})"
    if instant.start is None and instant.first is not None and start != instant.at:
        own = " to ".join(f"{round(frame, 2):g}" for frame in frames_of(codes, rate, instant, instant.at))
        begin = max(instant.at, instant.first)
        message = f"{what}, which cover frames {own} of this shot: they begin at frame {begin} instead"
        kept = f"at = {instant.at} with start = {written(instant.at):g} keeps their times"
        warnings.warn(f"{message} (at = {begin} states this, {kept})", stacklevel=3)
    if not codes[0] - 1.0 < start + instant.elapsed * rate < codes[-1] + 1.0:
        message = f"{what}, at the frames {first} to {last} of this shot: outside of them it holds still"
        warnings.warn(f"{message} (at = 1001 shows the first sample at frame 1001)", stacklevel=3)
    share = apart * instant.fps
    is_met = any(round(x) >= 1 and abs(x - round(x)) <= ROUNDED for x in (share, 1.0 / share))
    if instant.speed == 1.0 and len(gaps) > 1 and np.ptp(gaps) <= ROUNDED * apart and not is_met:
        message = f"{what}, the frames {first} to {last} of this shot 1/{instant.fps:g} s: frames lie between samples"
        right = f"speed = {share:.5g}, or fps = {1.0 / apart:.5g} of the graph, has one sample a frame"
        warnings.warn(f"{message} ({right})", stacklevel=3)


def read_at(source: Source, instant: Instant, written: Callable[[float], float] = float) -> Shape:
    """Return the mesh at an instant, with velocities: no more samples than one are in memory at a time.

    Warns where velocities of the file are not those of its points, and where its times do not meet those of the shot.

    written  value of the setting `start` for a time code
    """
    reference = 0 if instant.reference is None else int(np.abs(source.codes - instant.reference).argmin())
    shape = source.shape(reference)
    own = [instant.velocities == "file" and has for has in source.own]
    times = source.codes / source.rate
    code = place(source.codes, source.rate, instant)
    start = code / source.rate
    at = start + instant.elapsed
    if len(times) > 1:
        _warn_of_times(source.codes, source.rate, instant, code, written)
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
