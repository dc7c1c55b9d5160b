"""Bias without chaos: a model starts from the reference's own states, again and again, and runs for a few frames.

Climate models are judged so, by hindcasts or "Transpose-AMIP" (Phillips et al. 2004, Williams et al. 2013): what is
wrong shows before chaos has had time to grow.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.around import Around, frame_between
from hairpipe.measure.deviation import deviation
from hairpipe.measure.ensemble import interval_of_samples
from hairpipe.shot.settings import HairSettings
from hairpipe.shot.simulate import next_state, strands_of
from hairpipe.strands.hair_model import HairModel
from hairpipe.values import Strands, Table
from hairpipe.values.hair import HairState
from hairpipe.values.table import table_of_rows

WINDOWS = ("frame", "after 1 frame [% of length]", "after the window [% of length]")
SUMMARY = tuple(
    f"restart {name} [% of length]"
    for name in ("error", "low", "high", "median", "window error", "window low", "window high", "window median")
)


def restart_frames(frames: list[int], count: int, window: int) -> list[int]:
    """Spread restarts evenly over the frames of a shot, each with a window of frames after it.

    There are fewer where frames are. Raises BadInput where none fits, or frames are left out.
    """
    if frames[-1] - frames[0] + 1 != len(frames):
        raise BadInput("frames are missing, which a simulation needs", right="all frames in a row")
    if len(frames) <= window:
        raise BadInput(f"{len(frames)} frames", where="frames", right=f"more than the {window} of a window")
    places = (np.arange(count) + 1) * (len(frames) - 1 - window) // (count + 1)
    return [frames[place] for place in np.unique(places)]


def restart_tables(
    hair: HairModel,
    around: Around,
    settings: HairSettings,
    reference: tuple[Mapping[int, HairState], Mapping[int, Strands]],
    frame_dt: float,
    count: int,
    window: int,
) -> tuple[Table, Table]:
    """Return one row that sums up, and a row for every restart: errors against the reference's own strands.

    reference  its states and strands; count  of restarts; window  frames that each runs

    error   root mean square over strands and points, over the length, and over the restarts, with its 90 % interval
    median  over the restarts: those with much motion weigh less
    Errors of hair that is not finite are infinite. Raises BadInput where the reference has another cut or model.
    """
    states, truth = reference
    rows = []
    for frame in restart_frames(list(truth), count, window):
        check_state(hair, states[frame], truth[frame], settings)
        errors = list(_errors(hair, around, settings, states[frame], truth, (frame, window, frame_dt)))
        errors += [np.inf] * (window - len(errors))
        rows.append((frame, errors[0], errors[-1]))
    found = [value for errors in np.array(rows)[:, 1:].T for value in _summed(errors)]
    return table_of_rows(SUMMARY, [found]), table_of_rows(WINDOWS, rows)


def check_state(hair: HairModel, state: HairState, strands: Strands, settings: HairSettings) -> None:
    """Raise BadInput where hair cannot start from a state: it is of another cut, model or number, or in locks."""
    if (
        not np.array_equal(strands.offsets, hair.layout.offsets)
        or state.tensions.shape != hair.model.inverse_lengths.shape
    ):
        raise BadInput(
            "the state of the reference is of other strands, segments or springs",
            where="in.state",
            right="a reference with the same groom and model",
        )
    if state.locks is not None and settings.locks is None:
        raise BadInput(
            "the reference has locks", where="in.state", right="[locks] in this node, too, or a reference without locks"
        )


def _errors(
    hair: HairModel,
    around: Around,
    settings: HairSettings,
    state: HairState,
    truth: Mapping[int, Strands],
    when: tuple[int, int, float],
) -> Iterator[float]:
    """Run on from a state and return how far hair is from the reference after each frame [%], while it is finite."""
    frame, window, dt = when
    dtype = hair.layout.dtype
    names = ("velocities", "accelerations", "tensions")
    state = replace(state, **{name: getattr(state, name).astype(dtype) for name in names})
    for now in range(frame + 1, frame + window + 1):
        try:
            with np.errstate(all="ignore"):
                state = next_state(hair, state, frame_between(around, (now - 1, now), dt), settings)
            yield deviation(strands_of(hair, state), truth[now]).whole_percent
        except ArithmeticError:
            return


def _summed(errors: np.ndarray) -> list[float]:
    """Return root mean square, low, high and median of errors; the interval is one of their squares."""
    with np.errstate(invalid="ignore"):
        interval = np.maximum(interval_of_samples(errors**2), 0.0)
    return [*np.sqrt(interval), float(np.median(errors))]
