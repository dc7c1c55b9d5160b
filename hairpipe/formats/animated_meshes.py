"""An animated mesh at one instant, from the samples around it, which are read one by one.

Interpolation of samples in time: weights of the samples around an instant.

Between two samples points follow the cubic through both with the velocities there (Hermite). Velocities are those of
the file or, without any, the slope of the parabola through three samples: those before, at and after a sample, and the
nearest three at a cut and at an end. A value depends on two samples to either side of its instant, and on no others.

Files of an animated mesh: a numbered sequence, the layers and value clips of a stage, or buffers of glTF.
"""

import os
import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.gltf import SUFFIXES as GLTF
from hairpipe.formats.gltf import list_files as list_buffers
from hairpipe.formats.gltf import named
from hairpipe.formats.polygons import merge_meshes
from hairpipe.plain_file import stamp_of
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
    """Return the samples of the take that holds an instant; pure.

    times  of the samples, ascending [s], (n,)
    cuts   instants of the last frame before each cut and of the first one after it, ascending [s]; samples between the
           two belong to neither take

    Raises BadInput where a take has no sample.
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
    table = _Table()
    here = take.first + place
    if nearest in (place, place + 1) and abs(at - held[nearest]) <= SLACK * span:
        table.add(take.first + nearest, np.array([1.0, 0.0]))
        table.add_slope(times, take, take.first + nearest, own, np.array([0.0, 1.0]))
    elif 0.0 < share < 1.0 and len(held) > 1:
        square = share * share
        cube = square * share
        table.add(here, np.array([2.0 * cube - 3.0 * square + 1.0, 6.0 * (square - share) / span]))
        table.add(here + 1, np.array([3.0 * square - 2.0 * cube, 6.0 * (share - square) / span]))
        slope = np.array([(cube - 2.0 * square + share) * span, 3.0 * square - 4.0 * share + 1.0])
        table.add_slope(times, take, here, own, slope)
        table.add_slope(times, take, here + 1, own, np.array([(cube - square) * span, 3.0 * square - 2.0 * share]))
    else:
        end, is_cut = (take.first, take.opens) if share <= 0.0 else (take.last, take.closes)
        table.add(end, np.array([1.0, 0.0]))
        if is_cut:
            table.add_slope(times, take, end, own, np.array([at - times[end], 1.0]))
    return table.stencil()


class _Table:
    """Sums of weights by sample."""

    def __init__(self) -> None:
        self.weights: dict[int, np.ndarray] = {}

    def add(self, sample: int, weights: np.ndarray, kind: int = 0) -> None:
        """Add weights (2,) in the points and velocities, of the points (0) or velocities (1) of a sample, in place."""
        self.weights.setdefault(sample, np.zeros((2, 2)))[:, kind] += weights

    def add_slope(self, times: np.ndarray, take: Take, sample: int, own: bool, weights: np.ndarray) -> None:
        """Add weights (2,) of the velocity at a sample, in place."""
        at_cut = (sample == take.first and take.opens) or (sample == take.last and take.closes)
        if own and not at_cut:
            self.add(sample, weights, 1)
            return
        first = max(min(sample - 1, take.last - 2), take.first)
        around = range(first, min(first + 2, take.last) + 1)
        for one, slope in zip(around, slopes(times[first : around[-1] + 1], times[sample]), strict=True):
            self.add(one, slope * weights)

    def stencil(self) -> Stencil:
        """Return the sums in the order of the samples."""
        samples = sorted(self.weights)
        return Stencil(np.array(samples), np.array([self.weights[sample] for sample in samples]))


def slopes(times: np.ndarray, at: float) -> np.ndarray:
    """Return the weights of values in the slope at an instant of the polynomial through them, (n,); pure.

    times  of the values, one to three [s], (n,)
    """
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


USD = (".usd", ".usda", ".usdc", ".usdz")
NUMBERED = (".obj", ".ply")
ALEMBIC = ".abc"
SUFFIXES = (*USD, ALEMBIC, *GLTF, *NUMBERED)
MARK = re.compile(r"#+")
LAST_NUMBER = re.compile(r"\d+(?=\.\w+$)")
Stamps = dict[str, tuple[int, ...]]

_known: dict[Path, tuple[Stamps, dict[str, Path]]] = {}
"""Files of stages, with the stamps of these and of their folders: as long as all are unchanged, so is the list.

Files that do not exist have stamps, too: the stage is composed of them as soon as they do.
"""


def list_files(path: Path) -> dict[str, Path]:
    """Return the files that are read for a path, by their names; one alone has none.

    Those of a sequence such as `mesh.####.obj` are named by their numbers, those of a stage by relative paths.

    Raises BadInput where there are none, or where a stage cannot be read.
    """
    if is_sequence(path):
        return {str(number): file for number, file in numbered(path).items()}
    return list_parts(path)


def list_parts(path: Path) -> dict[str, Path]:
    """Return the files of a mesh, hair or motion that is not a sequence, as of `list_files`."""
    return list_layers(path) if path.suffix.lower() in USD and path.is_file() else list_buffers(path)


def is_sequence(path: Path) -> bool:
    """Whether a path is that of a numbered sequence; one without a mark for the number is that of a still mesh."""
    return path.suffix.lower() in NUMBERED and MARK.search(path.name) is not None


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
    for match in matches(path):
        number = int(match[1])
        if number in found:
            what = f"{match[0]} and {found[number].name} have the same number"
            raise BadInput(what, where=path, right="one file for each number")
        found[number] = path.parent / match[0]
        target = Path(os.path.realpath(found[number]))
        if target.suffix.lower() != path.suffix.lower():
            what = f"the file is a link to {target}"
            raise BadInput(what, where=found[number], right=f"a link to a {path.suffix} file, or no link")
    if not found:
        right = f"files such as {MARK.sub(f'{1001:0{len(marks[0][0])}d}', path.name)}"
        raise BadInput("the sequence has no files", where=path, right=right)
    return dict(sorted(found.items()))


def matches(path: Path) -> list[re.Match[str]]:
    """Match the names in the folder with that of a sequence, which has one mark; the group is the number."""
    before, mark, after = re.split(f"({MARK.pattern})", path.name)
    pattern = re.compile(rf"{re.escape(before)}(-?\d{{{len(mark)},}}){re.escape(after)}")
    names = sorted(file.name for file in path.parent.iterdir()) if path.parent.is_dir() else []
    return [match for match in map(pattern.fullmatch, names) if match]


def alone(path: Path) -> dict[int, Path]:
    """Return one file as a sequence of one; warns where it is one of several numbered files."""
    sequence = path.with_name(LAST_NUMBER.sub(lambda number: "#" * len(number[0]), path.name))
    count = len(matches(sequence)) if is_sequence(sequence) else 1
    if count > 1:
        message = f"{path} is one of {count} numbered files, and holds still: {sequence.name} reads all of them"
        warnings.warn(message, stacklevel=2)
    return {0: path}


def list_layers(path: Path) -> dict[str, Path]:
    """Return the existing files that a stage is composed of, and those of its value clips, by relative paths."""
    known = _known.get(path)
    if known is None or any(stamp_of(file) != stamp for file, stamp in known[0].items()):
        from hairpipe.apart import work_apart
        from hairpipe.formats.usd.layer_files import list_files as composed
        from hairpipe.formats.usd.layer_files import with_folders

        found = work_apart(composed, path)
        stamps = {str(place): stamp_of(str(place)) for place in with_folders(found)}
        _known[path] = known = stamps, named(path, [file for file in found if file.exists()])
    return known[1]
