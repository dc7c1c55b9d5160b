"""Cohesion of hair as particles: clumps, stretch, lost links, and a split that closes again."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from hairpipe.values import Cloud, Particles, Table
from hairpipe.values.groom import strand_lengths
from hairpipe.values.table import table_of_rows

FEW = 0.05  # share of each half that the gap may exclude: the particles nearest to the other half
CROSSED = 0.01  # distance beyond the end of the other half from which a particle is on the wrong side [m]
COLUMNS = (
    "frames reached",
    "nearest particle, of rest [%]",  # 1 % quantile of the distance to another one, over that at rest: less is clumped
    "stretch [%]",  # 99 % quantile of the distance to the next particle on the same hair over that at rest
    *("links out of reach [%]", "final links out of reach [%]"),  # longer than twice their reach: of zero strength
    *("final stretch [%]", "final speed [mm/s]"),  # root mean square
)
SPLIT = (
    *("initial gap [mm]", "largest gap [mm]", "final gap [mm]"),  # each side without the 5 % nearest to the other
    *("released links [%]", "final released links [%]"),  # links across that are out of reach, at the largest gap
    "particles on the wrong side [%]",  # more than 10 mm beyond the end of the other side, in the last frame
)


def cloud_table(cloud: Mapping[int, Cloud], particles: Particles) -> Table:
    """Return one row, of the worst of the frames that were reached by default."""
    order = np.lexsort((particles.arcs, particles.strands))
    same = particles.strands[order[1:]] == particles.strands[order[:-1]]
    near, far = order[:-1][same], order[1:][same]
    apart = _lengths(particles.points, near, far)
    nearest = np.quantile(_nearest(particles.points), 0.01)
    found = []
    last = cloud[max(cloud)]
    for frame in cloud:
        points = cloud[frame].points
        stretch = np.quantile(_lengths(points, near, far) / apart, 0.99) - 1.0
        found.append((np.quantile(_nearest(points), 0.01) / nearest, stretch, _open(points, particles).mean()))
    clumped, stretch, out = 100.0 * np.array(found).T
    speed = 1e3 * np.sqrt(np.mean(np.sum(last.velocities.astype(float) ** 2, axis=1)))
    row = (len(found), clumped.min(), stretch.max(), out.max(), out[-1], stretch[-1], speed)
    return table_of_rows(COLUMNS, [row])


def split_table(cloud: Mapping[int, Cloud], particles: Particles) -> Table:
    """Return one row, of the particles in the outer half of the length of their hair.

    They are split at the widest gap along x at any frame, in the middle half of the hair.
    """
    hair, ends = particles.hair, particles.links
    low = particles.arcs > 0.5 * strand_lengths(hair.points, hair.offsets)[particles.strands]
    rooms = {}  # width and middle of the widest gap
    for frame in cloud:
        x = np.sort(cloud[frame].points[low, 0])
        x = x[len(x) // 4 : -(len(x) // 4)]
        k = int(np.argmax(np.diff(x)))
        rooms[frame] = float(x[k + 1] - x[k]), float(0.5 * (x[k + 1] + x[k]))
    parted = max(rooms, key=lambda frame: rooms[frame][0])
    right = cloud[parted].points[:, 0] > rooms[parted][1]
    across = low[ends].all(axis=1) & (right[ends[:, 0]] != right[ends[:, 1]])
    gaps, opened = [], []
    begin = end = 0.0
    for frame in cloud:
        x = cloud[frame].points[:, 0]
        begin = np.quantile(x[low & right], FEW)
        end = np.quantile(x[low & ~right], 1.0 - FEW)
        gaps.append(1e3 * (begin - end))
        opened.append(100.0 * _open(cloud[frame].points, particles)[across].mean())
    last = cloud[max(cloud)].points[:, 0]
    wrong = 100.0 * np.mean(np.where(right, end - last, last - begin)[low] > CROSSED)
    return table_of_rows(SPLIT, [(gaps[0], max(gaps), gaps[-1], max(opened), opened[-1], wrong)])


def _nearest(points: np.ndarray) -> np.ndarray:
    return np.asarray(KDTree(points).query(points, k=2)[0])[:, 1]


def _open(points: np.ndarray, particles: Particles) -> np.ndarray:
    return _lengths(points, *particles.links.T) > 2.0 * particles.reach


def _lengths(points: np.ndarray, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[far] - points[near], axis=1)
