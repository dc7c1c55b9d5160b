"""The same hair in frames of other lengths: one curve."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.shot.settings import HairSettings
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import next_state, strands_of
from hairpipe.strands.hair_model import HairModel
from hairpipe.values import LevelSet, Table
from hairpipe.values.groom import strand_lengths
from hairpipe.values.table import table_of_rows

_ROUNDING = 1e-6
"""Part of a frame by which an interval that is written in decimals may differ from a number of frames."""
COLUMNS = ("frames a second", "time [s]", "difference [% of length]")


def rate_table(
    hair: HairModel,
    bodies: Sequence[LevelSet],
    settings: HairSettings,
    rates: Sequence[int],
    times: tuple[float, int],
    finer: int,
) -> Table:
    """Return a row for every rate [1/s] and time: distance from a run of the first rate in shorter steps.

    bodies  that stand still
    times   interval [s], and number of intervals from the start
    finer   factor by which the longest step of that run is shorter

    The distance is the largest of a point, over the length of the shortest strand. BadInput where an interval is not a
    positive number of frames, or there is no rate.
    """
    every, _ = times
    if not rates:
        raise BadInput("no frame rates", where="rates", right="one at least")
    for rate in rates:
        if every * rate < 0.5 or abs(every * rate - round(every * rate)) > _ROUNDING:
            raise BadInput(
                f"{every:g} s at {rate} frames a second is a fraction of a frame", where="every", right="a multiple"
            )
    short = replace(settings, steps=replace(settings.steps, longest=settings.steps.longest / finer))
    truth = list(followed(hair, bodies, short, rates[0], times))
    rows = []
    length = float(strand_lengths(hair.groom.points, hair.groom.offsets).min())
    for rate in rates:
        found = followed(hair, bodies, settings, rate, times)
        for place, (now, then) in enumerate(zip(found, truth, strict=True)):
            away = float(np.linalg.norm(now - then, axis=1).max())
            rows.append((rate, (place + 1) * every, 100.0 * away / length))
    return table_of_rows(COLUMNS, rows)


def followed(
    hair: HairModel, bodies: Sequence[LevelSet], settings: HairSettings, rate: int, times: tuple[float, int]
) -> Iterator[np.ndarray]:
    """Simulate hair at a rate [1/s], and return its points at every interval [m], (P, 3)."""
    every, count = times
    each = round(every * rate)
    still = [(body, body) for body in bodies]
    state = None
    for frame in range(1 + count * each):
        state = next_state(hair, state, Frame((None, None), still, [], (frame - 1) / rate, 1 / rate), settings)
        if frame and frame % each == 0:
            yield strands_of(hair, state).points.astype(float)
