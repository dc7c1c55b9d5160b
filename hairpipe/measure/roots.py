"""How the roots of hair are moved about, frame by frame."""

from collections.abc import Mapping

import numpy as np

from hairpipe.data import Ends, Groom, Mesh, Table
from hairpipe.data.table import table_of_columns


def measure_root_motion(groom: Groom, leads: Mapping[int, Mesh | Ends], fps: float) -> Table:
    """Return a row for every frame: root mean square, over the strands, of speed and acceleration of the roots.

    Differences between frames: v = (x(f+1) - x(f-1)) / 2 dt, a = (x(f+1) - 2 x(f) + x(f-1)) / dt^2; beyond its ends
    the motion goes on at constant speed.
    """
    frames = list(leads)
    places = np.array([root_places(groom, leads[frame]) for frame in frames])
    before = np.concatenate([2.0 * places[:1] - places[1:2], places[:-1]]) if len(frames) > 1 else places
    after = np.concatenate([places[1:], 2.0 * places[-1:] - places[-2:-1]]) if len(frames) > 1 else places
    return table_of_columns(
        {
            "frame": frames,
            "speed [m/s]": rms((after - before) * fps / 2.0),
            "acceleration [m/s^2]": rms((after - 2.0 * places + before) * fps**2),
        }
    )


def root_places(groom: Groom, lead: Mesh | Ends) -> np.ndarray:
    """Return where the roots are [m], (S, 3)."""
    if isinstance(lead, Ends):
        rest = groom.points[groom.offsets[:-1]]
        return np.einsum("sij,sj->si", lead.roots[:, :, :3], rest) + lead.roots[:, :, 3]
    corners = lead.points[lead.triangles[groom.root_triangles]]
    return np.einsum("sk,skc->sc", groom.root_barycentrics, corners)


def rms(vectors: np.ndarray) -> np.ndarray:
    """Return the root mean square length of vectors (frames, S, 3) over the strands, (frames,)."""
    return np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=1))
