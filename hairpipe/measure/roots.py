"""Speed and acceleration of the roots of hair, frame by frame."""

from collections.abc import Mapping, Sequence

import numpy as np

from hairpipe.data import Ends, Groom, Mesh, Table
from hairpipe.data.table import table_of_columns
from hairpipe.sim.boundary import check_driver


def measure_root_motion(
    groom: Groom, drivers: Mapping[int, Mesh | Ends], fps: float, cuts: Sequence[int] = ()
) -> Table:
    """Return a row for every frame: root mean square, over the strands, of speed and acceleration of the roots.

    drivers  bodies or ends at the frames of the run, ascending; frames may be missing
    cuts     frames at which the shot is cut: differences are one-sided there
    """
    frames = list(drivers)
    places = np.array([root_places(groom, drivers[frame]) for frame in frames])
    takes = np.split(np.arange(len(frames)), np.searchsorted(frames, cuts))
    found = [differences(places[take], np.array(frames)[take]) for take in takes if len(take)]
    rates, accelerations = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return table_of_columns(
        {"frame": frames, "speed [m/s]": rms(rates * fps), "acceleration [m/s^2]": rms(accelerations * fps**2)}
    )


def differences(values: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and the second derivative of values (n, ...) at ascending places (n,), by central differences.

    They need not be evenly spaced: the derivatives are those of a parabola through three neighbours. Beyond both ends
    values are extrapolated linearly, a single one as a constant.
    """
    first, second = np.zeros_like(values), np.zeros_like(values)
    if len(at) > 1:
        first = np.gradient(values, at, axis=0)
        slopes = np.diff(values, axis=0).T / np.diff(at)
        second[1:-1] = (2.0 * np.diff(slopes) / (at[2:] - at[:-2])).T
    return first, second


def root_places(groom: Groom, driver: Mesh | Ends) -> np.ndarray:
    """Return the positions of the roots [m], (S, 3); BadInput for the ends of another groom."""
    check_driver(driver, groom)
    if isinstance(driver, Ends):
        rest = groom.points[groom.offsets[:-1]]
        return np.einsum("sij,sj->si", driver.roots[:, :, :3], rest) + driver.roots[:, :, 3]
    corners = driver.points[driver.triangles[groom.root_triangles]]
    return np.einsum("sk,skc->sc", groom.root_barycentrics, corners)


def rms(vectors: np.ndarray) -> np.ndarray:
    """Return the root mean square length of vectors (frames, S, 3) over the strands, (frames,)."""
    return np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=1))
