"""Fidelity of a simulation: errors against a reference, and the frame of a failure."""

from collections.abc import Mapping, Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.measure.contact import depths, still
from hairpipe.measure.deviation import Deviation, deviation
from hairpipe.values import BodyParts, Groom, LevelSet, Strands, Table
from hairpipe.values.groom import segment_lengths, strand_lengths
from hairpipe.values.table import table_of_rows

COLUMNS = (
    *("tip error [% of length]", "strand error [% of length]", "tip error [mm]", "strand error [mm]"),
    *("largest error [mm]", "energy error [% of m g L]"),  # kinetic and potential, the mean over strands; NaN at g = 0
    *("deepest [mm]", "stretch [%]"),  # largest depth of a point inside bodies at a frame; NaN without bodies
    "failed",  # kind and frame of the failure, or empty
)


def fidelity_table(
    hair: Mapping[int, Strands],
    truth: Mapping[int, Strands],
    grooms: tuple[Groom, Groom] | None,
    surfaces: Sequence[Mapping[int, LevelSet]],
    parts: Sequence[Mapping[int, BodyParts]],
    gravity: float,
    bound: float,
    skip: int,
) -> Table:
    """Return one row: errors of hair against a reference, root mean squares over the frames.

    hair     hair at the frames that it reached; with fewer frames than the reference, it was not finite at the next:
             its errors are infinite, depth and stretch those of its frames
    grooms   of the hair and of the reference, whose strands correspond by ids; in order without
    gravity  along -Y [m/s^2]
    bound    largest stretch of a segment, over its length in the first frame, that is not a failure
    skip     frames at the beginning that are excluded, except for failures

    Raises BadInput where strands do not correspond, or no frames are left.
    """
    whose = None
    if grooms is not None:
        ours, theirs = (groom.ids for groom in grooms)
        order = np.argsort(theirs)
        whose = order[np.minimum(np.searchsorted(theirs[order], ours), len(order) - 1)]
        if missing := ours[theirs[whose] != ours].tolist():
            raise BadInput(f"the reference has no strand with id {missing[0]}", right="grooms with the same ids")
    found = []
    failed = ""
    rest = None
    for number, frame in enumerate(truth):
        if frame not in hair:
            failed = f"{failed}, " * bool(failed) + f"not finite at frame {frame}"
            found.append((*[np.inf] * 6, np.nan, np.nan))
            break
        now, reference = hair[frame], truth[frame]
        rest = segment_lengths(now.points, now.offsets) if rest is None else rest
        with np.errstate(all="ignore"):
            stretch = float((segment_lengths(now.points, now.offsets) / rest).max(initial=0.0)) - 1.0
            away, energy = _errors(now, reference, whose, gravity)
            error = (away.tip_percent, away.whole_percent, away.tip, away.whole, away.largest, energy)
        if stretch > bound and not failed:
            failed = f"stretched by more than {100 * bound:g} % at frame {frame}"
        if number >= skip:
            bodies = still((some[frame] for some in surfaces), (some[frame] for some in parts))
            deepest = depths(now, bodies).max(initial=0.0) if bodies else np.nan
            found.append((*error, deepest, stretch))
    if not found:
        raise BadInput("no frames are left to compare", right=f"more than {max(skip, 1)} frames")
    values = np.array(found)
    rms = np.sqrt(np.mean(values[:, [0, 1, 2, 3, 5]] ** 2, axis=0))
    deepest, stretch = 1e3 * np.fmax.reduce(values[:, 6]), 100.0 * np.fmax.reduce(values[:, 7])
    row = (*rms[:2], *(1e3 * rms[2:4]), 1e3 * values[:, 4].max(), 100.0 * rms[4], deepest, stretch, failed)
    return table_of_rows(COLUMNS, [row])


def _errors(hair: Strands, truth: Strands, whose: np.ndarray | None, gravity: float) -> tuple[Deviation, float]:
    """Return the distance of hair from the truth, and the error of its energy [m g L]."""
    try:
        away = deviation(hair, truth, whose)
    except ValueError as error:
        raise BadInput(f"hair and reference do not correspond: {error}", right="grooms, which give their ids") from None
    which = slice(None) if whose is None else whose
    lengths = strand_lengths(truth.points, truth.offsets)[which]
    energy = (_heads(hair, gravity) - _heads(truth, gravity)[which]) / lengths
    return away, float(np.mean(energy))


def _heads(hair: Strands, gravity: float) -> np.ndarray:
    """Return kinetic and potential energy of every strand over its weight m g [m], (S,); zero without gravity.

    Mass is even along a strand: half of a segment's at either of its ends.
    """
    starts = hair.offsets[:-1]
    ends = hair.offsets[1:] - 1
    if gravity == 0.0:
        return np.zeros(len(starts))
    weights = np.ones(len(hair.points))
    weights[starts] = weights[ends] = 0.5
    points = hair.points.astype(float)
    speeds = hair.velocities.astype(float)
    values = weights * (0.5 * np.sum(speeds**2, axis=1) / gravity + points[:, 1])
    return np.add.reduceat(values, starts) / (ends - starts)
