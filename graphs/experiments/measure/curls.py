"""Radii of curls."""

from collections.abc import Mapping

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import centres_of, turn_of
from hairpipe.values import Strands, Table
from hairpipe.values.table import table_of_columns


def measure_radii(hair: Mapping[int, Strands], fps: float) -> Table:
    """Return the radius of the curls at every frame, and what it is of that at the first; time zero is the first frame.

    curl radius  mean distance of the points from the centre line of their strand, over all strands that curl
    smallest     mean of the strand where it is least
    Raise BadInput where no strand makes a whole turn at the first frame.
    """
    frames = list(hair)
    first = hair[frames[0]]
    strands = list(zip(first.offsets, first.offsets[1:], strict=False))
    turns = [turn_of(first.points[begin:end].astype(float)) for begin, end in strands]
    curled = [(range_, turn) for range_, turn in zip(strands, turns, strict=True) if turn <= range_[1] - range_[0] - 2]
    if not curled:
        raise BadInput("no strand makes a whole turn", where="hair", right="curls, at the first frame")
    radii = np.array(
        [[radius(hair[f].points[begin:end].astype(float), turn) for (begin, end), turn in curled] for f in frames]
    )
    means = radii.mean(axis=1)
    return table_of_columns(
        {
            "time [s]": (np.array(frames) - frames[0]) / fps,
            "curl radius [mm]": 1e3 * means,
            "smallest [mm]": 1e3 * radii.min(axis=1),
            "of the first [%]": 100.0 * means / means[0],
        }
    )


def radius(points: np.ndarray, turn: float) -> float:
    """Return the mean distance of a curve, (n, 3), from its mean over one turn about each point, as far as that goes.

    turn  segments
    """
    centres, middle = centres_of(points, turn)
    return float(np.linalg.norm(points[middle] - centres, axis=1).mean())
