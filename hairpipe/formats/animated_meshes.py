"""An animated mesh at one instant, from the samples around it, which are read one by one.

Between two samples points follow the cubic through both with the velocities there (Hermite). Velocities are those of
the file or, without any, the slope of the parabola through three samples: those before, at and after a sample, and the
nearest three at a cut and at an end. A value depends on two samples to either side of its instant, and on no others.

A sequence of OBJ or PLY files, or one alone, is such a mesh: polygons of the first file, points of each.
"""

import os
import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.obj import read_points, read_polygons
from hairpipe.formats.ply import read_ply_mesh, read_ply_points
from hairpipe.formats.polygons import Polygons
from hairpipe.values import Mesh

SLACK = 1e-3
"""Distance from a sample at which an instant is the sample, as a share of the interval: files round their times."""


class Stencil(NamedTuple):
    """Linear combination of samples: points and velocities at an instant.

    samples  indices, (k,) int64
    weights  of the points [1] and velocities [s] of the samples in the points, and in the velocities [1/s], [1],
             (k, 2, 2) float64: [sample, in points or velocities, of points or velocities]
    """

    samples: np.ndarray
    weights: np.ndarray


class Take(NamedTuple):
    """Samples between which points move without a jump.

    first, last    both included
    opens, closes  whether there is a cut before the first, and after the last
    """

    first: int
    last: int
    opens: bool
    closes: bool


def take_at(times: np.ndarray, at: float, cuts: Sequence[tuple[float, float]]) -> Take:
    """Return the samples of the take that holds an instant; BadInput where it has none. Pure.

    times  of the samples, ascending [s], (n,)
    cuts   instants of the last frame before each cut and of the first one after it, ascending [s]; samples between the
           two belong to neither take
    """
    starts = [after - SLACK * (after - before) for before, after in cuts if after <= at]
    ends = [before + SLACK * (after - before) for before, after in cuts if after > at]
    first = int(np.searchsorted(times, max(starts, default=-np.inf), side="left"))
    last = int(np.searchsorted(times, min(ends, default=np.inf), side="right")) - 1
    if first > last:
        what = f"the file has no sample between the two cuts around {at:.3f} s"
        raise BadInput(what, where="cuts", right="one sample or more between two cuts")
    return Take(first, last, first > 0, last < len(times) - 1)


def stencil_at(times: np.ndarray, at: float, cuts: Sequence[tuple[float, float]], own: bool) -> Stencil:
    """Return the weights of the samples at an instant; pure.

    Outside of the samples their ends hold still. At a cut, motion goes on as at the last sample of the take.

    times, cuts  as of `take_at`
    own          whether samples have velocities; next to a cut they are not used, since programs compute them over it
    """
    take = take_at(times, at, cuts)
    held = times[take.first : take.last + 1]
    place = min(max(int(np.searchsorted(held, at, side="right")) - 1, 0), max(len(held) - 2, 0))
    span = float(np.diff(held[place : place + 2]).sum()) or 1.0
    share = (at - held[place]) / span
    nearest = place + round(share) if len(held) > 1 else place
    here = take.first + place

    def rate(sample: int, *weights: float) -> list[tuple[int, int, np.ndarray]]:
        """Return sample, kind and weights of the velocity at a sample: that of the file, or the slope of a parabola."""
        at_cut = (sample == take.first and take.opens) or (sample == take.last and take.closes)
        if own and not at_cut:
            return [(sample, 1, np.array(weights))]
        first = max(min(sample - 1, take.last - 2), take.first)
        around = range(first, min(first + 2, take.last) + 1)
        pairs = zip(around, slopes(times[first : around[-1] + 1], times[sample]), strict=True)
        return [(one, 0, slope * np.array(weights)) for one, slope in pairs]

    if nearest in (place, place + 1) and abs(at - held[nearest]) <= SLACK * span:
        terms = [(take.first + nearest, 0, np.array([1.0, 0.0])), *rate(take.first + nearest, 0.0, 1.0)]
    elif 0.0 < share < 1.0 and len(held) > 1:
        square = share * share
        cube = square * share
        terms = [
            (here, 0, np.array([2.0 * cube - 3.0 * square + 1.0, 6.0 * (square - share) / span])),
            (here + 1, 0, np.array([3.0 * square - 2.0 * cube, 6.0 * (share - square) / span])),
            *rate(here, (cube - 2.0 * square + share) * span, 3.0 * square - 4.0 * share + 1.0),
            *rate(here + 1, (cube - square) * span, 3.0 * square - 2.0 * share),
        ]
    else:
        end, is_cut = (take.first, take.opens) if share <= 0.0 else (take.last, take.closes)
        terms = [(end, 0, np.array([1.0, 0.0])), *(rate(end, at - times[end], 1.0) if is_cut else ())]
    sums = dict[int, np.ndarray]()
    for sample, kind, weights in terms:
        sums.setdefault(sample, np.zeros((2, 2)))[:, kind] += weights
    samples = sorted(sums)
    return Stencil(np.array(samples), np.array([sums[sample] for sample in samples]))


def slopes(times: np.ndarray, at: float) -> np.ndarray:
    """Return the weights of values at one to three times [s] in the slope at an instant of the polynomial, (n,)."""
    powers = np.arange(len(times))
    ahead = np.vander(times - at, increasing=True)
    return np.linalg.solve(ahead.T, (powers == 1).astype(float)) if len(times) > 1 else np.zeros(1)


AT = 1001
"""Frame of the shot at which a file begins, or the first of a later shot, where its own times are before the shot."""
ROUNDED = 1e-3
"""Difference of a number of samples per frame from a whole one, or from a whole number of frames per sample."""
SLOW, ALIKE = 0.01, 0.5
"""Root mean square of velocities that are not compared [m/s], and largest difference of others, as a share."""


@dataclass(frozen=True)
class Instant:
    """What is read from an animated mesh.

    start       time code of the file at the frame `at`, see `Samples.rate`; None for that of `place`
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


Points = tuple[np.ndarray, np.ndarray | None]
"""Points of a mesh [m or file units] and their velocities [1/s], (n, 3) float64 each, None for a mesh without any."""


class Samples(Protocol):
    """Samples of an animated mesh, which consists of meshes with the same points at all times.

    codes  time codes of the samples, ascending, (t,) float64
    rate   time codes per second [1/s]
    own    whether the samples of each mesh have velocities
    """

    codes: np.ndarray
    rate: float

    @property
    def own(self) -> Sequence[bool]: ...

    def shape(self, sample: int) -> Polygons:
        """Read the triangles at a sample, and all points there; BadInput where they are invalid."""
        ...

    def sample(self, sample: int) -> list[Points]:
        """Read the points of the meshes at a sample; BadInput where they are invalid, or polygons have changed."""
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
    """Warn where times of file and shot do not meet, with the settings that make them meet."""
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


def read_at(source: Samples, instant: Instant, written: Callable[[float], float] = float) -> Polygons:
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
            for weights in stencils[has].weights[stencils[has].samples == sample]:
                _add(points[part], weights[0], given)
                _add(velocities[part], weights[1], given)
            for weights in stencils[False].weights[stencils[False].samples == sample]:
                _add(slopes[part], weights[1], given)
    if any(own):
        sizes = [np.sqrt(np.square(rates).sum(axis=1).mean()) for rates in (velocities, slopes, velocities - slopes)]
        if max(sizes[:2]) > SLOW and sizes[2] > ALIKE * max(sizes[:2]):
            what = "velocities of the file are not those of its points, which may mean units per frame"
            warnings.warn(f'{what} (velocities = "samples" computes them from the points)', stacklevel=2)
    mesh = shape.mesh
    return Polygons(Mesh(points, mesh.triangles, instant.speed * velocities, mesh.uv), shape.owners)


def _add(sums: np.ndarray, weights: np.ndarray, given: Points) -> None:
    """Add the weighted points and velocities of a sample to sums (n, 3), in place."""
    for weight, values in zip(weights, given, strict=True):
        if weight != 0.0 and values is not None:
            sums += weight * values


READERS = {".obj": (read_polygons, read_points), ".ply": (read_ply_mesh, read_ply_points)}
"""Readers of triangles, and of points with a digest of the polygons, by suffix."""
MARK = re.compile(r"#+")
LAST_NUMBER = re.compile(r"\d+(?=\.\w+$)")


class FileSequence:
    """Samples of a sequence, see `animated_meshes.Samples`; the number of a file is its time code.

    A file alone, whose path has no mark for a number, is a sequence of one: a mesh that holds still.

    Raises BadInput for a sequence without files; warns of missing numbers, and of one file of many.
    """

    own = (False,)

    def __init__(self, path: Path, group: str | None, fps: float) -> None:
        files = numbered(path) if is_sequence(path) else _alone(path)
        self.group, self.rate = group, fps
        self.files = list(files.values())
        self.read_shape, self.read_points = READERS[path.suffix.lower()]
        self.codes = np.array(list(files), np.float64)
        self.first = recall(First, self.files[0], group)
        gaps = np.diff(self.codes)
        if len(gaps) and gaps.max() > gaps.min():
            after = int(self.codes[np.argmax(gaps)])
            message = f"{path}: files after number {after} are missing: points are interpolated over the gap"
            warnings.warn(message, stacklevel=2)

    def shape(self, sample: int) -> Polygons:
        return self.read_shape(self.files[sample], self.group) if sample else self.first.shape

    def sample(self, sample: int) -> list[Points]:
        """Read the points of a file; BadInput where its faces are not those of the first one."""
        file = self.files[sample]
        first = self.files[0].name
        points, faces = self.read_points(file)
        if len(points) != len(self.first.shape.mesh.points):
            right = f"{len(self.first.shape.mesh.points):,} as {first} has"
            raise BadInput(f"the file has {len(points):,} vertices", where=file, right=right)
        if faces != self.first.faces:
            raise BadInput("the faces have changed", where=file, right=f"those of {first}")
        return [(points, None)]


class First:
    """Triangles of the first file, and digest of its polygons."""

    def __init__(self, path: Path, group: str | None) -> None:
        read_shape, read_points = READERS[path.suffix.lower()]
        self.files = [path]
        self.shape: Polygons = read_shape(path, group)
        self.faces = read_points(path)[1]


def read_sequence(path: Path, group: str | None, instant: Instant) -> Polygons:
    """Read the mesh of a sequence at an instant."""
    return read_at(FileSequence(path, group, instant.fps), instant)


def is_sequence(path: Path) -> bool:
    """Whether a path is that of a numbered sequence; one without a mark for the number is that of a still mesh."""
    return path.suffix.lower() in READERS and MARK.search(path.name) is not None


def numbered(path: Path) -> dict[int, Path]:
    """Return the files of a sequence in the order of their numbers, which replace the only `####` of the name.

    Numbers may be longer than the mark, and negative. Links are followed to files of the same suffix.

    Raises BadInput where there are none, two of one number, or a link to a file of another suffix.
    """
    marks = list(MARK.finditer(path.name))
    if len(marks) != 1:
        right = f"one mark for the number, such as {path.stem}.####{path.suffix}"
        raise BadInput(f"the name of a sequence has {len(marks)} marks", where=path, right=right)
    found: dict[int, Path] = {}
    for match in _matches(path):
        number = int(match[1])
        if number in found:
            what = f"{match[0]} and {found[number].name} have the same number"
            raise BadInput(what, where=path, right="one file for each number")
        found[number] = path.parent / match[0]
        target = Path(os.path.realpath(found[number]))
        if target.suffix.lower() != path.suffix.lower():
            right = f"a link to a {path.suffix} file, or no link"
            raise BadInput(f"the file is a link to {target}", where=found[number], right=right)
    if not found:
        right = f"files such as {MARK.sub(f'{1001:0{len(marks[0][0])}d}', path.name)}"
        raise BadInput("the sequence has no files", where=path, right=right)
    return dict(sorted(found.items()))


def _matches(path: Path) -> list[re.Match[str]]:
    """Match the names in the folder with that of a sequence, which has one mark; the group is the number."""
    before, mark, after = re.split(f"({MARK.pattern})", path.name)
    pattern = re.compile(rf"{re.escape(before)}(-?\d{{{len(mark)},}}){re.escape(after)}")
    names = sorted(file.name for file in path.parent.iterdir()) if path.parent.is_dir() else []
    return [match for match in map(pattern.fullmatch, names) if match]


def _alone(path: Path) -> dict[int, Path]:
    """Return one file as a sequence of one; warns where it is one of several numbered files."""
    sequence = path.with_name(LAST_NUMBER.sub(lambda number: "#" * len(number[0]), path.name))
    count = len(_matches(sequence)) if is_sequence(sequence) else 1
    if count > 1:
        message = f"{path} is one of {count} numbered files, and holds still: {sequence.name} reads all of them"
        warnings.warn(message, stacklevel=2)
    return {0: path}
