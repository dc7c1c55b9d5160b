"""A straight strand held at both ends is twisted until it buckles: the onset compared with Greenhill's."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Pose, Specimen, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, least_stiffness, motions
from hairpipe.graphs.experiments.studies.accuracy.torsion import held_length, twisted_on
from hairpipe.graphs.experiments.studies.theory.twist_buckling import buckling_twist
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

_STEPS = 24
"""Steps of the twist, from zero to the onset of the theory."""
_FINEST = 1e-3
"""Width at which the bisection for the onset stops, as a fraction of the onset of the theory."""
_BEYOND = 1.5
_ASIDE = 0.1
"""Way of the axis from the straight line, over the length, at which a strand has writhed."""
_SOFT = 0.25
"""Stiffness over that without twist below which it ends in buckling; above, its springs have given way."""
COLUMNS = ("strand", "segments", "twist / onset in theory", "stiffness / that without twist")
ONSET = ("strand", "segments", "theory [rad]", "strand [rad]", "error [%]", "stiffness left", "ends by")


class State(NamedTuple):
    """A strand that still stands: twist [rad], pose, and its smallest stiffness [N/m]."""

    twist: float
    pose: Pose
    stiffness: float


def writhe_tables(sample: Sample, segments: Sequence[int]) -> tuple[Table, Table]:
    """Tabulate the smallest stiffness along the way, and where the way ends: at its first zero the strand writhes."""
    way, onset = [], []
    for count in segments:
        specimen = straight_specimen(sample, count)
        theory = buckling_twist(held_length(specimen), sample.material.bending, sample.material.torsion)
        states = list(stand(specimen, theory, standing))
        if not states:
            raise BadInput(f"{count} segments are not straight without twist", right="springs that bend and twist")
        unit = states[0].stiffness
        way += [(sample.name(count), count, state.twist / theory, state.stiffness / unit) for state in states]
        last = states[-1].twist
        left = states[-1].stiffness / unit
        how = "writhing" if left < _SOFT else "springs"
        onset.append((sample.name(count), count, theory, last, 100 * (last / theory - 1), left, how))
    return table_of_rows(COLUMNS, way), table_of_rows(ONSET, onset)


def stand(
    specimen: Specimen, theory: float, further: Callable[[Specimen, State, float], State | None]
) -> Iterator[State]:
    """Twist a strand from none on for as long as it stands stable, the last steps by halves.

    theory   onset of buckling [rad]
    further  twists it on from a state to a twist [rad]; None where it has no stable equilibrium near that state
    """
    now = further(specimen, State(0.0, specimen.rest, 0.0), 0.0)
    step = theory / _STEPS
    if now is not None:
        yield now
    while now is not None and step > _FINEST * theory and now.twist < _BEYOND * theory:
        after = further(specimen, now, now.twist + step)
        if after is None:
            step /= 2
        else:
            now = after
            yield now


def standing(specimen: Specimen, before: State, twist: float) -> State | None:
    """Twist a strand on; None where it has no straight, stable equilibrium near the one before."""
    free = motions(specimen, slides=True)
    guess = twisted_on(specimen, before.pose, twist, twist - before.twist)
    at = balance(specimen, guess, specimen.nothing(), free)
    aside = np.linalg.norm(specimen.axis(at.pose)[:, :2], axis=1).max() / (specimen.segment * specimen.segments)
    if not at.found or aside > _ASIDE:
        return None
    least = least_stiffness(specimen, at.pose, free)
    return State(twist, at.pose, least) if least > 0 else None
