"""A tuft of strands from a row of them."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from hairpipe.data import Groom
from hairpipe.groom.random_streams import stream
from hairpipe.units import Degrees, Ge, Interval, Metres


@dataclass(frozen=True)
class Tuft:
    """Further rows of strands, and random directions of strands.

    rows   number of rows of strands
    apart  distance from one row to the next
    stray  root mean square angle between strands and the common direction
    seed   seed of the random numbers
    """

    rows: Annotated[int, Interval(ge=1, le=10_000)] = 1
    apart: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.01)
    stray: Annotated[Degrees, Interval(ge=0.0, le=90.0)] = 0.0
    seed: Annotated[int, Ge(0)] = 0


def gather_tuft(row: Groom, tuft: Tuft) -> Groom:
    """Return rows like this one, every strand turned about its root by a rotation of its own; pure."""
    from hairpipe.groom.joining import joined_strands  # heavy, where nodes read the settings above

    step = np.array(tuft.apart)
    groom = joined_strands(tuple(moved(row, k * step) for k in range(tuft.rows)))
    count = len(groom.ids)
    about = stream(tuft.seed, "stray").normal(size=(count, 3)) * np.radians(tuft.stray) / np.sqrt(2.0)
    turns = rotations(about)
    roots = groom.root_frames[:, :, 3]
    strands = np.repeat(np.arange(count), np.diff(groom.offsets))
    points = roots[strands] + np.einsum("pij,pj->pi", turns[strands], groom.points - roots[strands])
    frames = np.concatenate([turns @ groom.root_frames[:, :, :3], roots[:, :, None]], axis=2)
    return replace(groom, points=points, root_frames=frames)


def moved(groom: Groom, shift: np.ndarray) -> Groom:
    """Return a groom somewhere else; pure."""
    frames = groom.root_frames.copy()
    frames[:, :, 3] += shift
    return replace(groom, points=groom.points + shift, root_frames=frames)


def rotations(vectors: np.ndarray) -> np.ndarray:
    """Return the rotations about vectors by their length [rad], (n, 3), as matrices (n, 3, 3): Rodrigues."""
    angles = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    sine = np.sinc(angles / np.pi)
    cosine = 0.5 * np.sinc(0.5 * angles / np.pi) ** 2
    return np.eye(3) + sine * cross + cosine * (cross @ cross)
