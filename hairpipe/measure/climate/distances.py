"""Distances of all pairs of runs of an ensemble: of points, and of observables."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hairpipe.data import Strands
from hairpipe.data.lengths import segment_lengths
from hairpipe.errors import BadInput
from hairpipe.measure.climate.observables import (
    contacts,
    density,
    density_distance,
    gaps,
    kinetic_energy,
    log_spectrum,
    places,
    resampled,
    silhouette_distance,
    silhouettes,
    strain,
    tip_speeds,
    wasserstein,
)
from hairpipe.measure.deviation import deviation
from hairpipe.measure.patches import part

Run = Mapping[int, Strands]


class Criteria(NamedTuple):
    """Criteria of comparison.

    tolerance  tolerance of points, over the length of their strands
    patches    number of patches of consecutive strands, as equal as possible
    reach      distance up to which two points touch [m]
    gravity    [m/s^2], the scale of energy
    fps        frames per second [1/s]
    predicted  number of predictable frames after the first; None: found by the tolerance
    """

    tolerance: float
    patches: int
    reach: float
    gravity: float
    fps: float
    predicted: int | None = None


def _apart(one: Any, other: Any) -> float:
    """Return the distance of two numbers, or the mean distance of those of two arrays."""
    return float(np.mean(np.abs(one - other)))


OBSERVABLES: Mapping[str, Callable[[Any, Any], float]] = {
    "position": wasserstein,
    "density": density_distance,
    "silhouettes": silhouette_distance,
    "nearest strand": _apart,
    "contacts": _apart,
    "kinetic energy": _apart,
    "strain": _apart,
}
"""Observables of a frame, and their distances between two runs."""
TESTED = (*OBSERVABLES, "speed spectrum")
"""The same, and the observables of all frames together."""


def position_squares(runs: Sequence[Run], frames: Sequence[int], patches: int) -> np.ndarray:
    """Return mean squares of the distances of points of two runs, over their length [%^2], (frames, patches, K, K).

    Runs are compared at the points of the last run. Raises BadInput if strands do not correspond.
    """
    found = np.zeros((len(frames), patches, len(runs), len(runs)))
    for row, frame in zip(found, frames, strict=True):
        hairs = _hairs(runs, frame)
        count = len(hairs[0].offsets) - 1
        if count < patches:
            raise BadInput(f"{count} strands in {patches} patches", where="patches", right="fewer")
        bounds = [patch * count // patches for patch in range(patches + 1)]
        for patch, matrix in enumerate(row):
            parts = [part(hair, *bounds[patch : patch + 2]) for hair in hairs]
            matrix[:] = _matrix(parts, lambda one, other: deviation(one, other).whole_percent ** 2)
    return found


def observable_distances(runs: Sequence[Run], frames: Sequence[int], criteria: Criteria) -> np.ndarray:
    """Return distances of runs in every observable, means over the frames, (Q, K, K) in the order of `TESTED`."""
    rests = _rests(runs)
    total = np.zeros((len(OBSERVABLES), len(runs), len(runs)))
    speeds = []
    for frame in frames:
        hairs = _hairs(runs, frame)
        speeds.append([tip_speeds(hair) for hair in hairs])
        strains = [strain(run[frame], rest) for run, rest in zip(runs, rests, strict=True)]
        views = [observables(hair, criteria) | {"strain": found} for hair, found in zip(hairs, strains, strict=True)]
        total += [_matrix([view[name] for view in views], apart) for name, apart in OBSERVABLES.items()]
    spectra = [log_spectrum(np.array(series), criteria.fps) for series in zip(*speeds, strict=True)]
    return np.concatenate([total / len(frames), [_matrix(spectra, _rms)]])


def observables(hair: Strands, criteria: Criteria) -> dict[str, Any]:
    """Return the observables of hair at a frame, by name, without strain."""
    return {
        "position": places(hair),
        "density": density(hair),
        "silhouettes": silhouettes(hair),
        "nearest strand": gaps(hair),
        "contacts": contacts(hair, criteria.reach),
        "kinetic energy": kinetic_energy(hair, criteria.gravity),
    }


def _hairs(runs: Sequence[Run], frame: int) -> list[Strands]:
    """Return the hair of all runs at a frame, resampled to the points of the last run."""
    hairs = [run[frame] for run in runs]
    try:
        return [resampled(hair, hairs[-1].offsets) for hair in hairs]
    except ValueError as wrong:
        raise BadInput(f"members do not correspond: {wrong}", where="in.hair", right="the same strands") from None


def _rests(runs: Sequence[Run]) -> list[np.ndarray]:
    """Return the lengths of segments of each run at its first frame [m]."""
    hairs = [run[next(iter(run))] for run in runs]
    return [segment_lengths(hair.points, hair.offsets) for hair in hairs]


def _matrix(values: Sequence[Any], apart: Callable[[Any, Any], float]) -> np.ndarray:
    """Return the distances of all values, (K, K)."""
    found = np.zeros((len(values), len(values)))
    for one in range(len(values)):
        for other in range(one):
            found[one, other] = found[other, one] = apart(values[one], values[other])
    return found


def _rms(one: np.ndarray, other: np.ndarray) -> float:
    """Return the root mean square distance of two series."""
    return float(np.sqrt(np.mean((one - other) ** 2)))
