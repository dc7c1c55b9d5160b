"""Hair in locks, frame by frame: simulated strands, and errors of followers."""

from collections.abc import Mapping

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.segments import ages_of
from hairpipe.measure.ensemble import uncertainty
from hairpipe.values import Groom, Strands, Table
from hairpipe.values.hair import Audit, HairState, no_locks
from hairpipe.values.table import table_of_rows

LASTED = 5  # fewest frames of a lasting connection
COLUMNS = (
    *("time [s]", "connections per segment", f"connections of {LASTED} or more frames [%]", "simulated [%]"),
    "released, of simulated [%]",  # former followers, neither back in a lock nor guides of others
    "largest lock",
    "guide disagreement [mm]",  # estimated rms error of points of followers from the guides; 0 without followers
    "audited strands",  # whose audit ended at this frame (`shot/locks.py`)
    "audit error [mm]",  # rms distance of their points from the places that their guides predict; NaN without audits
    "audit error bound [mm]",  # of all followers, confidence of 90 %, independent locks; NaN for fewer than two
    *("error [mm]", "error [% of length]"),  # rms distance of all points from the truth, NaN without truth
)


def measure_locks(
    groom: Groom,
    hair: Mapping[int, Strands],
    states: Mapping[int, HairState],
    truth: Mapping[int, Strands] | None,
    fps: float,
) -> Table:
    """Return a row for every frame; time zero is the first frame. BadInput where the truth is of other strands."""
    frames = list(hair)
    rows = []
    segments = np.diff(groom.points, axis=0)
    inner = np.delete(np.linalg.norm(segments, axis=1), groom.offsets[1:-1] - 1)
    length = inner.sum() / len(groom.ids)
    ages = np.zeros(0, np.int32)
    before = None
    for frame in frames:
        state = states[frame]
        if before is None:
            ages = np.zeros(len(state.stuck), np.int32)
        else:
            ages = ages_of(before.stuck, before.stuck_at, ages, state.stuck, state.stuck_at)
        before = state
        locks = state.locks or no_locks(len(groom.ids))
        apart = 0.0
        if len(locks.disagreement):
            apart = 1e3 * float(np.sqrt((locks.disagreement.astype(float) ** 2).mean()))
        off = np.nan
        if truth is not None and frame in truth:
            if not np.array_equal(hair[frame].offsets, truth[frame].offsets):
                right = "in.truth: the same groom without locks"
                raise BadInput("hair and truth are not the same strands", right=right)
            off = float(np.sqrt(((hair[frame].points - truth[frame].points) ** 2).sum(axis=1).mean()))
        lasting = 100.0 * float((ages >= LASTED).mean()) if len(ages) else 0.0
        stuck = len(ages) / len(inner), lasting
        simulated = np.count_nonzero(~locks.follows)
        released = 100.0 * np.count_nonzero(locks.released) / simulated
        shares = 100.0 * simulated / len(groom.ids), released, int(np.bincount(locks.leaders).max())
        rows.append(
            ((frame - frames[0]) / fps, *stuck, *shares, apart, *_audited(locks.audit), 1e3 * off, 100.0 * off / length)
        )
    return table_of_rows(COLUMNS, rows)


def _audited(audit: Audit | None) -> tuple[int, float, float]:
    """Return the number of audited strands, their rms error [mm], and its bound [mm]."""
    if audit is None:
        return 0, np.nan, np.nan
    hairs = audit.hairs
    squares = audit.errors**2
    mean = np.average(squares, weights=hairs)
    bound = np.nan
    if len(squares) > 1:
        # Variance of a ratio of means: sums of squares over the strands of a lock, and their number.
        apart = hairs * (squares - mean) / hairs.mean()
        bound = mean + uncertainty(apart)
    return int(hairs.sum()), 1e3 * float(np.sqrt(mean)), 1e3 * float(np.sqrt(bound))
