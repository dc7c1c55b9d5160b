"""Impulse that goals and pins add to hair."""

from collections.abc import Mapping

import numpy as np

from hairpipe.data import Groom, Table
from hairpipe.data.hair import HairState
from hairpipe.data.table import table_of_rows
from hairpipe.groom.sampling import members_of

COLUMNS = (
    "time [s]",
    "impulse x [N s]",
    "impulse y [N s]",
    "impulse z [N s]",
    "mean force [N]",
    "largest force on a strand [N]",
)


def measure_impulses(groom: Groom, states: Mapping[int, HairState], group: str | None, fps: float) -> Table:
    """Return a row a frame: the impulse of goals in the solves of its steps, before contact; zero without goals.

    mean force                 magnitude of the impulse over the duration of a frame
    largest force on a strand  the same of the strand with the largest impulse

    Raises BadInput for a group that the groom does not have.
    """
    some = slice(None) if group is None else members_of(groom, (group,), "group")
    rows = []
    for n, state in enumerate(states.values()):
        impulses = np.zeros((len(groom.ids), 3)) if state.impulses is None else state.impulses
        total = impulses[some].sum(axis=0)
        largest = np.linalg.norm(impulses[some], axis=1).max()
        rows.append((n / fps, *total.tolist(), fps * float(np.linalg.norm(total)), fps * float(largest)))
    return table_of_rows(COLUMNS, rows)
