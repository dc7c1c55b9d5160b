"""Torsion of a straight strand: the torque compared with GJ, and the shift of a free tip."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import (
    Pose,
    Specimen,
    forces,
    held_at_tip,
    moved,
    stiffness,
    straight_specimen,
)
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, motions
from hairpipe.strands.interface import may_be_lost
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

COLUMNS = (
    "strand",
    "segments",
    "twist [rad]",
    "torque error [%]",
    "tip shift [% of length per rad]",
    "no equilibrium",
)


class Twisted(NamedTuple):
    """A strand between a clamp and a turned, sliding one: twist [rad], pose, torque [N m], whether at rest."""

    twist: float
    pose: Pose
    torque: float
    found: bool


def torsion_table(sample: Sample, segments: Sequence[int], twists: Sequence[float]) -> Table:
    """Tabulate the torque for twists of both senses [rad], ascending in size, and the shift of a free tip."""
    rows = []
    for count in segments:
        specimen = straight_specimen(sample, count)
        shift = 100 * tip_shift(specimen)
        back, forth = (list(twist(specimen, [sense * size for size in twists])) for sense in (-1, 1))
        for state in [*reversed(back), *forth]:
            error = 100 * (state.torque / (sample.material.torsion * state.twist / held_length(specimen)) - 1)
            rows.append((sample.name(count), count, state.twist, error, shift, int(not state.found)))
    return table_of_rows(COLUMNS, rows)


def held_length(specimen: Specimen) -> float:
    """Length of the rod between the clamps [m]: at the far one half a joint is held, too."""
    return specimen.segment * (specimen.segments - 0.5)


def twist(specimen: Specimen, twists: Sequence[float]) -> Iterator[Twisted]:
    """Turn the far end step by step [rad]; it may slide along the axis, so that no tension arises."""
    pose = specimen.rest
    now = 0.0
    free = motions(specimen, slides=True)
    for turn in twists:
        pose = twisted_on(specimen, pose, turn, turn - now)
        now = turn
        at = balance(specimen, pose, specimen.nothing(), free)
        pose = at.pose
        x = pose.x[-specimen.shape.clamped :]
        held = forces(specimen, pose)[-specimen.shape.clamped :]
        torque = np.cross(x, held[:, :3])[:, 2].sum() + specimen.lever * held[:, 3:].sum()
        yield Twisted(turn, pose, -float(torque), at.found)


def twisted_on(specimen: Specimen, pose: Pose, turn: float, more: float) -> Pose:
    """Twist a strand evenly by more [rad], and put its held ends where a twist of turn [rad] has them."""
    rest, clamped = specimen.rest.x, specimen.shape.clamped
    tip = rest[specimen.tip, 2]
    height = np.clip(rest[:, 2] / tip, 0, 1)
    height[-clamped:] = 1.0
    way = specimen.spun(pose, more * height)
    end = rest + specimen.spun(specimen.rest, np.full(len(rest), turn))[:, :3]
    end[:, 2] += pose.x[specimen.tip, 2] - tip
    way[:clamped, :3] = (rest - pose.x)[:clamped]
    way[-clamped:, :3] = (end - pose.x)[-clamped:]
    return held_at_tip(specimen, moved(specimen, pose, way))


def couple(specimen: Specimen) -> np.ndarray:
    """Load of a unit couple about the axis on the end, (rows, unknowns); times a motion it is the angle of the end."""
    load = specimen.nothing()
    clamped = specimen.shape.clamped
    if may_be_lost(specimen.model):
        load[-clamped, 3] = 1 / specimen.lever
        return load
    if specimen.shape.stride == 1:
        raise BadInput("particles on a line cannot be twisted", where="sample.model", right='"network" or "rod"')
    arms = specimen.rest.x[-clamped:] - specimen.rest.x[-clamped:].mean(axis=0)
    inertia = np.eye(3) * np.sum(arms**2) - arms.T @ arms
    load[-clamped:] = np.cross(np.linalg.solve(inertia, [0.0, 0.0, 1.0]), arms)
    return load


def tip_shift(specimen: Specimen) -> float:
    """Shift of a free tip over the length per radian that a small couple about the axis turns it by."""
    load = couple(specimen).reshape(-1)
    free = motions(specimen)
    way = free @ np.linalg.solve(free.T @ stiffness(specimen, specimen.rest) @ free, free.T @ load)
    aside = np.linalg.norm(way.reshape(len(specimen.mass), -1)[specimen.tip, :2])
    return float(aside / abs(load @ way) / (specimen.segment * specimen.segments))
