"""How particles that stand for hair hold together: clumps, stretch, links lost, and a split that closes again."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from hairpipe.data import Cloud, Particles, Table
from hairpipe.data.lengths import strand_lengths
from hairpipe.data.table import table_of_rows

FEW = 0.05
"""Share of each half that may lie nearer to the other than the gap is wide."""
CROSSED = 0.01
"""What is farther beyond the end of the other half than this is on the wrong side [m]."""
COLUMNS = (
    "frames reached",
    "nearest, of that at rest [%]",
    "stretch [%]",
    "links out of reach [%]",
    "at the end [%]",
    "stretch at the end [%]",
    "speed at the end [mm/s]",
)
SPLIT = (
    "gap at first [mm]",
    "widest [mm]",
    "at the end [mm]",
    "links released [%]",
    "open at the end [%]",
    "on the wrong side [%]",
)


def cloud_table(cloud: Mapping[int, Cloud], particles: Particles) -> Table:
    """Return one row, of the worst frame where nothing else is said.

    cloud    at the frames that were reached
    nearest  1 % quantile of the distance to the nearest other particle, over that at rest: less is clumped
    stretch  99 % quantile, of the distance to the next particle on the same hair over that at rest
    links    share of them that are longer than twice their reach, so that they have faded
    speed    root mean square
    """
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
    """Return one row, of what is farther from the root than half of its hair.

    Its halves lie on both sides of the widest room along x that there is at any frame, in the middle half of the hair.

    gap       between the halves: each without the 5 % nearest to the other
    released  links from one half to the other that are out of reach, at the widest
    wrong     particles that end more than 10 mm beyond where the other half ends
    """
    hair, ends = particles.hair, particles.links
    low = particles.arcs > 0.5 * strand_lengths(hair.points, hair.offsets)[particles.strands]
    rooms = {frame: _widest(cloud[frame].points[low, 0]) for frame in cloud}
    parted = max(rooms, key=lambda frame: rooms[frame][0])
    right = cloud[parted].points[:, 0] > rooms[parted][1]
    across = low[ends].all(axis=1) & (right[ends[:, 0]] != right[ends[:, 1]])
    gaps = []
    opened = []
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


def _widest(x: np.ndarray) -> tuple[float, float]:
    """Return the width and the middle of the widest room between numbers, in the middle half of them."""
    x = np.sort(x)[len(x) // 4 : -(len(x) // 4)]
    widest = int(np.argmax(np.diff(x)))
    return float(x[widest + 1] - x[widest]), float(0.5 * (x[widest + 1] + x[widest]))


def _nearest(points: np.ndarray) -> np.ndarray:
    """Return the distance to the nearest other point [m], (N,)."""
    return np.asarray(KDTree(points).query(points, k=2)[0])[:, 1]


def _open(points: np.ndarray, particles: Particles) -> np.ndarray:
    """Return which links are out of reach, (E,)."""
    return _lengths(points, *particles.links.T) > 2.0 * particles.reach


def _lengths(points: np.ndarray, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[far] - points[near], axis=1)
