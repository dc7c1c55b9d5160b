"""Rod theory of weightless strands with prescribed ends that move slowly."""

from collections.abc import Iterator, Mapping

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.strands import bulge, measure
from hairpipe.graphs.experiments.studies.theory.clamps import Clamp, rest_shape, span_rod
from hairpipe.graphs.experiments.studies.theory.kirchhoff import Rod, Shape
from hairpipe.graphs.experiments.studies.theory.rod_frames import frames_of
from hairpipe.values import Ends, Groom, Strands, Table

MOST_TURN = 0.5
"""Largest change of a quaternion in a frame, or part of one, at which a rod still follows; beyond, it has snapped."""
SMALLEST = 1 / 16
"""Part of a frame below which there is no way on."""


def driven_rod(groom: Groom, ends: Mapping[int, Ends], fps: float, bending: float, torsion: float) -> Table:
    """Return the table of `measure` for a Kirchhoff rod in place of the first strand, balanced at every frame.

    bending, torsion  EI and GJ [N m^2]

    The rod is straight by nature, or an arc with the bulge of the strand. It is followed from frame to frame until it
    finds no equilibrium near the one before: there it snaps, and the table ends.
    """
    points = groom.points[: groom.offsets[1]]
    rod, start = rod_of(points, bending, torsion)
    shapes = dict(zip(ends, follow(rod, start, list(ends.values())), strict=False))
    if not shapes:
        raise BadInput("the rod finds no equilibrium at the first frame", right="ends where the groom has them")
    hair = {frame: strands_of(shape, len(points)) for frame, shape in shapes.items()}
    return measure(hair, fps, {frame: first_of(ends[frame]) for frame in hair})


def rod_of(points: np.ndarray, bending: float, torsion: float) -> tuple[Rod, Clamp]:
    """Make a rod of a strand, (n, 3) [m], and say where it starts: it is an arc from its root to its tip."""
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    along = (points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0])
    middle = points[len(points) // 2] - points[0]
    aside = middle - (middle @ along) * along
    size = np.linalg.norm(aside)
    towards = aside / size if size > 0.0 else np.linalg.svd(along[None])[2][1]
    curvature = 8.0 * bulge(points) / length**2
    half = curvature * length / 2.0
    tangent = np.cos(half) * along + np.sin(half) * towards
    normal = np.cos(half) * towards - np.sin(half) * along
    frame = np.column_stack([normal, np.cross(tangent, normal), tangent])
    return Rod(length, bending, torsion, np.array([0.0, -curvature, 0.0]), np.zeros(3)), Clamp(points[0], frame)


def follow(rod: Rod, start: Clamp, ends: list[Ends]) -> Iterator[Shape]:
    """Balance a rod for ends led from frame to frame, in parts of a frame where it takes that, until it snaps."""
    shape = rest_shape(rod, start)
    end = Clamp(shape.points[-1], frames_of(shape.quaternions[-1:].T)[0])
    known = [(-1.0, shape), (-0.5, shape)]
    done, part = -0.5, 0.5
    while done < len(ends) - 1:
        goal = done + part
        holds = [between([getattr(hold, name)[0] for hold in ends], goal) for name in ("roots", "tips")]
        found = balanced(rod, driven(start, holds[0]), driven(end, holds[1]), onward(known, goal), known[-1][1])
        if found is not None:
            known = [known[-1], (goal, found)]
            done = goal
            part = min(1.0, 2.0 * part) if done % (2.0 * part) == 0.0 else part
            if done == int(done):
                yield found
        elif part > SMALLEST:
            part /= 2.0
        else:
            return


def balanced(rod: Rod, start: Clamp, end: Clamp, guess: Shape, before: Shape) -> Shape | None:
    """Balance a rod near a guess; None where there is nothing near the shape before."""
    try:
        found = span_rod(rod, start, end, guess)
    except ArithmeticError:
        return None
    turned = np.linalg.norm(found.quaternions - at(before, found.arc).quaternions, axis=1)
    return found if turned.max() < MOST_TURN else None


def between(motions: list[np.ndarray], time: float) -> np.ndarray:
    """Return the rigid motion, (3, 4), at a time in frames: the first before them, between two the mean of both."""
    first = int(max(np.floor(time), 0))
    share = max(time, 0.0) - first
    mean = (1.0 - share) * motions[first] + share * motions[min(first + 1, len(motions) - 1)]
    left, _, right = np.linalg.svd(mean[:, :3])
    return np.column_stack([left @ right, mean[:, 3]])


def driven(clamp: Clamp, motion: np.ndarray) -> Clamp:
    """Move a clamp rigidly, by (3, 4)."""
    return Clamp(motion[:, :3] @ clamp.point + motion[:, 3], motion[:, :3] @ clamp.frame)


def onward(known: list[tuple[float, Shape]], goal: float) -> Shape:
    """Guess the shape at a time from the two before it, on a straight line."""
    (first, before), (second, now) = known
    ahead = (goal - second) / (second - first)
    old = at(before, now.arc)
    values = ("points", "quaternions", "force", "couple")
    points, turns, force, couple = (
        (1.0 + ahead) * getattr(now, value) - ahead * getattr(old, value) for value in values
    )
    return Shape(now.arc, points, turns / np.linalg.norm(turns, axis=1, keepdims=True), force, couple)


def at(shape: Shape, arc: np.ndarray) -> Shape:
    """Read a shape at other places along the arc [m]."""
    values = (shape.points, shape.quaternions, shape.force, shape.couple)
    return Shape(arc, *(np.column_stack([np.interp(arc, shape.arc, part) for part in value.T]) for value in values))


def strands_of(shape: Shape, count: int) -> Strands:
    """Show a rod as a strand of equal segments."""
    arc = np.linspace(0.0, shape.arc[-1], count)
    points = at(shape, arc).points
    return Strands(points, np.zeros_like(points, np.float32), np.array([0, count], np.int32), 0.0)


def first_of(ends: Ends) -> Ends:
    """Keep the ends of the first strand."""
    return Ends(ends.roots[:1], ends.roots_rate[:1], ends.tips[:1], ends.tips_rate[:1])
