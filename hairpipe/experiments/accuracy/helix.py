"""A curl hangs from its root: how far its weight draws it out, and how stiff it is, against Kirchhoff's rod."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from hairpipe.data import Table
from hairpipe.data.table import table_of_rows
from hairpipe.experiments.accuracy.sample import Sample
from hairpipe.experiments.accuracy.specimen import Specimen, specimen_of
from hairpipe.experiments.accuracy.statics import balance, motions, stiffness
from hairpipe.groom.helix import Helix, wound
from hairpipe.rod.clamps import Clamp, hang_rod
from hairpipe.rod.kirchhoff import Rod

_SMALL = 1e-3
"""Force that the spring is tried with, over E I / L^2."""
COLUMNS = ("segments", "gravity [m/s^2]", "sag [% of height]", "sag error [%]", "stiffness error [%]", "no equilibrium")


def helix_table(sample: Sample, curl: Helix, segments: Sequence[int], gravities: Sequence[float]) -> Table:
    """Tabulate the sag of a curl with its axis down, for gravities [m/s^2], ascending, and its small stiffness."""
    rows = []
    for count in segments:
        points = wound(curl, sample.length, count)
        specimen = specimen_of(sample, points)
        rod, clamp = rod_of(sample, curl, points)
        soft = 100 * (spring_of_network(specimen) / spring_of_rod(rod, clamp) - 1)
        for gravity, sagged, found in sag(specimen, gravities):
            weight = np.array([0.0, 0.0, sample.material.line_density * gravity])
            theory = hang_rod(replace(rod, weight=weight), clamp).points[-1, 2] - points[-1, 2]
            error = 100 * (sagged / theory - 1)
            rows.append((count, gravity, 100 * theory / points[-1, 2], error, soft, int(not found)))
    return table_of_rows(COLUMNS, rows)


def rod_of(sample: Sample, curl: Helix, points: np.ndarray) -> tuple[Rod, Clamp]:
    """Return the rod that runs through points on a helix along +Z, and how it is clamped at the first of them."""
    turn = 2 * np.arcsin(np.linalg.norm(points[1, :2] - points[0, :2]) / (2 * curl.radius))
    rise = curl.pitch / (2 * np.pi)
    per_turn = np.hypot(curl.radius, rise)
    bend, twist = curl.radius / per_turn**2, rise / per_turn**2
    tangent, inward = np.array([0.0, curl.radius, rise]) / per_turn, np.array([-1.0, 0.0, 0.0])
    frame = np.column_stack([np.cross(tangent, inward), -inward, tangent])
    material = sample.material
    length = float(turn * per_turn * (len(points) - 1))
    rod = Rod(length, material.bending, material.torsion, np.array([bend, 0.0, twist]), np.zeros(3))
    return rod, Clamp(points[0], frame)


def sag(specimen: Specimen, gravities: Sequence[float]) -> Iterator[tuple[float, float, bool]]:
    """Follow the tip down as gravity grows: gravity [m/s^2], sag [m], and whether the strand came to rest."""
    x, free = specimen.rest, motions(specimen)
    for gravity in gravities:
        at = balance(specimen, x, specimen.mass[:, None] * np.array([0.0, 0.0, gravity]), free)
        x = at.positions
        yield gravity, float(x[-1, 2] - specimen.rest[-1, 2]), at.found


def spring_of_network(specimen: Specimen) -> float:
    """Small force along the axis on the tip over its way [N/m]."""
    free = motions(specimen)
    load = np.zeros_like(specimen.rest)
    load[-1, 2] = 1.0
    way = free @ np.linalg.solve(free.T @ stiffness(specimen, specimen.rest) @ free, free.T @ load.reshape(-1))
    return float(1 / way.reshape(-1, 3)[-1, 2])


def spring_of_rod(rod: Rod, clamp: Clamp) -> float:
    """Return the same of the rod [N/m], as the mean of a pull and a push."""
    force = np.array([0.0, 0.0, _SMALL * rod.bending / rod.length**2])
    pulled, pushed = (hang_rod(rod, clamp, sign * force).points[-1, 2] for sign in (1, -1))
    return float(2 * force[2] / (pulled - pushed))
