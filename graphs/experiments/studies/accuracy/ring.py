"""A straight strand that is closed to a ring and twisted: the onset of buckling compared with Michell's.

A ring whose ends are joined under a twist leaves its plane beyond 2 pi sqrt(3) EI / GJ (Michell 1889; Zajac 1962;
Goriely, J. Elasticity 84, 2006). Ends that are held at one place with one tangent are joined ends: only a motion of the
whole ring is left out. What remains without stiffness is a turn about that tangent, in which a straight, round rod
spins in itself: the point opposite stays in the plane.
"""

from collections.abc import Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Pose, Specimen, held_at_tip, moved, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, least_stiffness, motions
from hairpipe.graphs.experiments.studies.accuracy.torsion import held_length
from hairpipe.graphs.experiments.studies.accuracy.writhe import State, stand
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

_ASIDE = 0.1
"""Way of a point from the ring, over the length, at which it has buckled."""
COLUMNS = ("strand", "segments", "theory [rad]", "strand [rad]", "error [%]", "stiffness left")


def ring_table(sample: Sample, segments: Sequence[int]) -> Table:
    """Tabulate the twist up to which a ring is stable, and its smallest stiffness there over that without twist."""
    theory = buckling_twist(sample.material.bending, sample.material.torsion)
    rows = []
    for count in segments:
        states = list(stand(straight_specimen(sample, count), theory, standing))
        if not states:
            raise BadInput(f"{count} segments have no ring without twist", right="more segments")
        last = states[-1]
        left = last.stiffness / states[0].stiffness
        rows.append((sample.name(count), count, theory, last.twist, 100 * (last.twist / theory - 1), left))
    return table_of_rows(COLUMNS, rows)


def buckling_twist(bending: float, torsion: float) -> float:
    """Twist between the joined ends at which a ring of a straight rod buckles [rad]; EI and GJ in one unit."""
    return 2 * np.pi * np.sqrt(3) * bending / torsion


def standing(specimen: Specimen, before: State, twist: float) -> State | None:
    """Twist a ring on; None where it has no stable equilibrium near the one before. At rest it is closed first."""
    free = ring_motions(specimen)
    pose = closed(specimen) if before.pose is specimen.rest else before.pose
    at = balance(specimen, twisted_on(specimen, pose, before.twist, twist), specimen.nothing(), free)
    aside = np.linalg.norm((at.pose.x - ringed(specimen, twist))[specimen.shape.axis], axis=1).max()
    if not at.found or aside > _ASIDE * specimen.segment * specimen.segments:
        return None
    least = least_stiffness(specimen, at.pose, free)
    return State(twist, at.pose, least) if least > 0 else None


def ring_motions(specimen: Specimen) -> np.ndarray:
    """Motions that are left to a ring, as columns: see `motions`, less the slide, and Y of the point opposite."""
    free = motions(specimen, slides=True)[:, :-1]
    opposite = specimen.nothing()
    opposite[np.arange(len(opposite))[specimen.shape.axis][specimen.segments // 2], 1] = 1
    return free[:, opposite.reshape(-1) @ free == 0]


def closed(specimen: Specimen) -> Pose:
    """Bend a strand that stands along +Z to a ring, without twist, in so small steps that frames are carried along."""
    pose = specimen.rest
    for step in range(specimen.segments):
        way = specimen.nothing()
        way[:, :3] = ringed(specimen, 0.0, (step + 1) / specimen.segments) - pose.x
        pose = moved(specimen, pose, way)
    return pose


def twisted_on(specimen: Specimen, pose: Pose, before: float, twist: float) -> Pose:
    """Twist a ring evenly from one angle between its ends to another [rad]."""
    way = specimen.nothing()
    way[:, :3] = ringed(specimen, twist) - ringed(specimen, before)
    way[:, 3:] = specimen.lever * (twist - before) * arcs(specimen)[:, None] / held_length(specimen)
    return held_at_tip(specimen, moved(specimen, pose, way))


def ringed(specimen: Specimen, twist: float, part: float = 1.0) -> np.ndarray:
    """Return the rows of a strand along +Z that is twisted evenly [rad] and bent in X and Z to a part of a ring."""
    arc = arcs(specimen)
    beyond = specimen.rest.x[:, 2] - arc
    length = held_length(specimen)
    x, y, _ = (specimen.rest.x + specimen.spun(specimen.rest, twist * arc / length)[:, :3]).T
    bend = 2 * np.pi * part / length
    c = np.cos(bend * arc)
    s = np.sin(bend * arc)
    return np.column_stack([(1 - c) / bend + x * c + beyond * s, y, s / bend - x * s + beyond * c])


def arcs(specimen: Specimen) -> np.ndarray:
    """Return where rows belong between the clamps [m], (rows,): held ones at an end."""
    length = held_length(specimen)
    arc = np.clip(specimen.rest.x[:, 2], 0, length)
    arc[-specimen.shape.clamped :] = length
    return arc
