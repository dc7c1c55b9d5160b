"""A helical strand that hangs from its root: sag and stiffness compared with Kirchhoff's rod."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Specimen, specimen_of, stiffness
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, motions
from hairpipe.graphs.experiments.studies.theory.clamps import Clamp, hang_rod
from hairpipe.graphs.experiments.studies.theory.kirchhoff import Rod
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

_AT_REST = 1e-5
"""Step over the length of a segment: coarse curls are near a switch of their altitude springs."""
_SMALL = 1e-3
"""Force that the spring is tried with, over E I / L^2."""
COLUMNS = (
    "strand",
    "segments",
    "gravity [m/s^2]",
    "sag [% of height]",
    "sag error [%]",
    "stiffness error [%]",
    "no equilibrium",
)


def helix_table(
    sample: Sample, curl: Helix, segments: Sequence[int], gravities: Sequence[float], orientations: int
) -> Table:
    """Tabulate the sag of a curl with its axis down, for gravities [m/s^2], ascending, and its small stiffness.

    orientations  that curls of either hand are brought to, and gravity with them; errors are the largest of all
    """
    rows = []
    for count in segments:
        points = wound(curl, sample.length, count)
        rod, clamp = rod_of(sample, curl, points)
        cases = [(specimen_of(sample, points @ turn.T), turn[:, 2]) for turn in turns(orientations)]
        stiff = spring_of_rod(rod, clamp)
        soft = largest([100 * (spring_of_strand(specimen, axis) / stiff - 1) for specimen, axis in cases])
        sags = [list(sag(specimen, gravities, axis)) for specimen, axis in cases]
        for gravity, found in zip(gravities, zip(*sags, strict=True), strict=True):
            weight = np.array([0.0, 0.0, sample.material.line_density * gravity])
            theory = hang_rod(replace(rod, weight=weight), clamp).points[-1, 2] - points[-1, 2]
            error = largest([100 * (sagged / theory - 1) for sagged, _ in found])
            lost = sum(not at_rest for _, at_rest in found)
            rows.append((sample.name(count), count, gravity, 100 * theory / points[-1, 2], error, soft, lost))
    return table_of_rows(COLUMNS, rows)


def turns(count: int) -> Iterator[np.ndarray]:
    """Return so many rotations, each also with a reflection before it, which winds a curl the other way, (3, 3)."""
    from scipy.spatial.transform import Rotation

    for turn in Rotation.from_rotvec(np.arange(count)[:, None] * np.array([0.9, -1.7, 0.6])).as_matrix():
        yield turn
        yield turn @ np.diag([1.0, -1.0, 1.0])


def largest(errors: Sequence[float]) -> float:
    """Return the error that is farthest from nothing, with its sign."""
    return max(errors, key=abs)


def rod_of(sample: Sample, curl: Helix, points: np.ndarray) -> tuple[Rod, Clamp]:
    """Return the rod that runs through points on a helix along +Z, and how it is clamped at the first of them."""
    turn = 2 * np.arcsin(np.linalg.norm(points[1, :2] - points[0, :2]) / (2 * curl.radius))
    rise = curl.pitch / (2 * np.pi)
    per_turn = np.hypot(curl.radius, rise)
    bend = curl.radius / per_turn**2
    twist = rise / per_turn**2
    tangent = np.array([0.0, curl.radius, rise]) / per_turn
    inward = np.array([-1.0, 0.0, 0.0])
    frame = np.column_stack([np.cross(tangent, inward), -inward, tangent])
    material = sample.material
    length = float(turn * per_turn * (len(points) - 1))
    rod = Rod(length, material.bending, material.torsion, np.array([bend, 0.0, twist]), np.zeros(3))
    return rod, Clamp(points[0], frame)


def sag(specimen: Specimen, gravities: Sequence[float], down: np.ndarray) -> Iterator[tuple[float, bool]]:
    """Follow the tip down, (3,), as gravity grows [m/s^2]: sag [m], and whether the strand came to rest."""
    pose = specimen.rest
    free = motions(specimen)
    for gravity in gravities:
        at = balance(specimen, pose, specimen.weight(gravity * down), free)
        pose = at.pose
        yield float((pose.x - specimen.rest.x)[specimen.tip] @ down), at.found


def spring_of_strand(specimen: Specimen, axis: np.ndarray) -> float:
    """Small force along the axis, (3,), on the tip over its way [N/m]."""
    free = motions(specimen)
    stiff = stiffness(specimen, specimen.rest, _AT_REST)
    load = specimen.nothing()
    load[specimen.tip, :3] = axis
    way = free @ np.linalg.solve(free.T @ stiff @ free, free.T @ load.reshape(-1))
    return float(1 / (load.reshape(-1) @ way))


def spring_of_rod(rod: Rod, clamp: Clamp) -> float:
    """Return the same of the rod [N/m], as the mean of a pull and a push."""
    force = np.array([0.0, 0.0, _SMALL * rod.bending / rod.length**2])
    pulled, pushed = (hang_rod(rod, clamp, sign * force).points[-1, 2] for sign in (1, -1))
    return float(2 * force[2] / (pulled - pushed))
