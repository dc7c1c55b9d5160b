"""Distance of hair from that of a mirrored or scaled scene."""

from collections.abc import Mapping

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Strands, Table
from hairpipe.values.groom import strand_lengths
from hairpipe.values.table import table_of_rows

COLUMNS = ("time [s]", "difference [% of length]")


def differences(
    hair: Mapping[int, Strands],
    truth: Mapping[int, Strands],
    fps: float,
    mirror: str | None,
    scale: float,
    slower: int,
) -> Table:
    """Return a row for every frame of the truth whose time, times `slower`, is a frame of the hair.

    The difference is the largest distance of a point over the length of the shortest strand.

    BadInput where strands differ in points.
    """
    frames = list(hair)
    sign = np.array([-1.0 if mirror == axis else 1.0 for axis in "xyz"])
    first = hair[frames[0]]
    length = float(strand_lengths(first.points, first.offsets).min())
    rows = []
    for place, frame in enumerate(frames[::slower]):
        now = hair[frame]
        then = truth[frames[place]]
        if now.points.shape != then.points.shape:
            raise BadInput(f"{len(now.points)} and {len(then.points)} points", right="strands of equal segments")
        away = np.linalg.norm(now.points - scale * sign * then.points.astype(float), axis=1)
        rows.append(((frame - frames[0]) / fps, 100.0 * float(away.max()) / length))
    return table_of_rows(COLUMNS, rows)
