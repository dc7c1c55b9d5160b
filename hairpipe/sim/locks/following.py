"""Strands of locks at the end of a frame, interpolated outside of bodies, and the errors of the interpolation."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Strands
from hairpipe.data.locks import LockState
from hairpipe.groom.keys.push_out import pushed_out
from hairpipe.groom.strand_arrays import points_of_strands
from hairpipe.sim.boundary import motion_of_roots
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.locks.carrying import interpolated
from hairpipe.sim.locks.guides import GuideMotion
from hairpipe.sim.shot import Frame


class Followed(NamedTuple):
    """All strands at the end of a frame.

    points, velocities  as shown: followers interpolated, the others simulated [m], [m/s], (P, 3)
    interpolated        compared strands interpolated, too [m], (P, 3)
    disagreement        disagreement of the guides of each strand, rms over its points [m], (S,)
    pushed              displacement of each strand by bodies, rms [m], (S,)
    errors              error of each compared strand against its own simulation, rms [m], (S,)
    """

    points: np.ndarray
    velocities: np.ndarray
    interpolated: np.ndarray
    disagreement: np.ndarray
    pushed: np.ndarray
    errors: np.ndarray


def follow(hair: HairModel, known: LockState, motion: GuideMotion, frame: Frame, thickness: float) -> Followed:
    """Interpolate followers and compared strands, and push them out of bodies to a distance [m]; pure."""
    offsets = hair.layout.offsets
    disagreement = np.zeros(len(known.roles))
    strands = np.flatnonzero(known.interpolated)
    if not len(strands):
        return Followed(motion.points, motion.velocities, motion.points, *[disagreement] * 3)
    roots = motion_of_roots(frame.drivers[1], hair.groom)
    rows = points_of_strands(strands, offsets)
    points = motion.points.copy()
    velocities = motion.velocities.copy()
    points[rows], velocities[rows], disagreement[strands] = interpolated(
        strands, known.places, motion, offsets, hair.groom.points, roots, hair.diameter
    )
    surfaces = [after for _, after in frame.surfaces]
    parts = [after for _, after in frame.parts]
    inside = Strands(points, velocities, offsets, hair.diameter)
    outside = pushed_out(inside, known.interpolated, surfaces, parts, thickness, frame.frame_dt)
    pushed = distances(outside.points, points, offsets)
    errors = distances(outside.points, motion.points, offsets)
    follows = np.repeat(known.follows, np.diff(offsets))[:, None]
    shown = np.where(follows, outside.points, motion.points)
    speeds = np.where(follows, outside.velocities, motion.velocities)
    return Followed(shown, speeds, outside.points, disagreement, pushed, errors)


def distances(points: np.ndarray, others: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the rms distance over the points of each strand [m], (S,); pure."""
    return np.sqrt(np.add.reduceat(((points - others) ** 2).sum(axis=1), offsets[:-1]) / np.diff(offsets))
