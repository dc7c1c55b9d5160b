"""Attraction of hair to a target density: equation (3) of Petrovic, Henne, Anderson 2005.

With rho the length of hair per volume, rho_t that of the target, rho_0 = sum rho_t^2 / sum rho_t its mean weighted by
hair, h the cell and w a rate, on each of some grids

    E = w^2 h^2 / (2 rho_0) sum_g h^3 (rho - rho_t)^2,   a_i = -(dE/dx_i) / l_i

for point i of length l_i. We differ from the paper: its general formula has the other sign, which ascends; it lacks the
factor 1/h; and its tents have a gradient that jumps across faces of cells, unlike quadratic B-splines. Each grid has
cells twice as large as the one before, for distant hair: the paper begins with coarse grids, here all of them act at
once, with the same equilibrium.

Stiffness is bounded by the density at a node over rho_0, times w^2. So that a step of any length stays stable, the
difference at node g is divided by 1 + 6 n (w dt)^2 r_g, r_g the greater density there over rho_0, n the number of
grids; with short steps that is 1.

Along an axis, with d = u - i from the nearest node i, -1/2 to 1/2, the splines at the three nodes around it, and their
derivatives, are

    w = (1/2 - d)^2 / 2,   3/4 - d^2,   (1/2 + d)^2 / 2
    w' = d - 1/2,          -2 d,        d + 1/2

Grids have a margin of a node on every side: (0, 0, 0) is the node before the first one around the hair.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.laws.settings import Target
from hairpipe.solve.interactions import Interaction, StepEnd
from hairpipe.values import Density
from hairpipe.volume.transfer import StrandSamples, cells_of, sample_strands, share_of

_CHUNK = 128  # strands that are collected together


def weigh(samples: StrandSamples, amounts: np.ndarray) -> np.ndarray:
    """Splat amounts of points, (P,), to the nodes, (nx + 2, ny + 2, nz + 2)."""
    own = np.divide(amounts, samples.sums, out=np.zeros(len(amounts)), where=samples.sums > 0.0)
    grid = np.zeros(samples.counts + 2)
    for parity in range(2):
        _weigh(samples, own, parity, grid)
    return grid


@njit(cache=True, parallel=True, error_model="numpy")
def _weigh(samples, own, parity, grid):
    """Splat the samples of every second slab to the nodes, in place: these slabs share no nodes."""
    slabs = samples.slabs
    inverse = 1.0 / samples.cell
    for n in prange((len(slabs) - parity) // 2):  # Three nodes reach one plane beyond a slab: every second is apart.
        slab = 2 * n + parity
        for at in range(slabs[slab], slabs[slab + 1]):
            k = samples.segments[at]
            t = share_of(samples.places[at], samples.pieces[k])
            amount = own[k] + t * (own[k + 1] - own[k])
            u, v, w = cells_of(samples, k, t, inverse)
            (i, x), (j, y), (l, z) = _around(u), _around(v), _around(w)
            wx, wy, wz = _weights(x), _weights(y), _weights(z)
            for a in range(3):
                for b in range(3):
                    for c in range(3):
                        grid[i + a, j + b, l + c] += amount * wx[a] * wy[b] * wz[c]


@njit(cache=True, parallel=True, error_model="numpy")
def add_slopes(samples: StrandSamples, own: np.ndarray, field: np.ndarray, out: np.ndarray) -> None:
    """Add the derivative of sum_g field_g amount_g by every point to out, (P, 3), in place.

    own    amounts of points for each of their pieces, amounts / sums, (P,)
    field  at the nodes, (nx + 2, ny + 2, nz + 2)
    """
    offsets = samples.offsets
    pieces = samples.pieces
    inverse = 1.0 / samples.cell
    strands = len(offsets) - 1
    for chunk in prange((strands + _CHUNK - 1) // _CHUNK):
        for k in range(offsets[chunk * _CHUNK], offsets[min((chunk + 1) * _CHUNK, strands)]):
            for place in range(pieces[k]):
                t = share_of(place, pieces[k])
                u, v, w = cells_of(samples, k, t, inverse)
                slope = _slope(field, u, v, w)
                amount = inverse * (own[k] + t * (own[k + 1] - own[k]))
                for c in range(3):
                    out[k, c] += (1.0 - t) * amount * slope[c]
                    out[k + 1, c] += t * amount * slope[c]


@inlined
def _slope(field, u, v, w):
    """Return the gradient of the spline of a field at a point, by cells."""
    (i, x), (j, y), (l, z) = _around(u), _around(v), _around(w)
    wx, wy, wz = _weights(x), _weights(y), _weights(z)
    dx, dy, dz = _slopes(x), _slopes(y), _slopes(z)
    gx, gy, gz = 0.0, 0.0, 0.0
    for a in range(3):
        for b in range(3):
            for c in range(3):
                value = field[i + a, j + b, l + c]
                gx += dx[a] * wy[b] * wz[c] * value
                gy += wx[a] * dy[b] * wz[c] * value
                gz += wx[a] * wy[b] * dz[c] * value
    return gx, gy, gz


@inlined
def _around(u):
    """Index of the first of the three nodes around a place, with the margin, and how far from the second it is."""
    i = int(np.floor(u + 0.5))
    return i, u - i


@inlined
def _weights(d):
    return 0.5 * (0.5 - d) ** 2, 0.75 - d * d, 0.5 * (0.5 + d) ** 2


@inlined
def _slopes(d):
    return d - 0.5, -2.0 * d, d + 0.5


STIFFNESS = 6.0


class TargetGrid(NamedTuple):
    """The target density on one grid.

    low     of the first node, in cells from the world's origin, (3,) int64
    cell    [m]
    length  of hair per volume [m/m^3], (nx, ny, nz) float64
    """

    low: np.ndarray
    cell: float
    length: np.ndarray


def target_grids(target: Density, cell: float, levels: int, total: float) -> list[TargetGrid]:
    """Return a density on grids, each of cells twice as large as the one before, scaled to a length of hair [m]; pure.

    Raise BadInput where there is no hair in it, or its cells are larger than the smallest here.
    """
    if not target.length.any():
        raise BadInput("there is no hair in the target", where="in.target", right="a density that is not 0 everywhere")
    if target.cell > 1.001 * cell:
        what = f"the target has cells of {target.cell:g} m, more than volume.target.cell = {cell:g} m"
        raise BadInput(what, where="volume.target.cell", right=f"at least {target.cell:g} m, or a finer target")
    places = np.argwhere(target.length)
    amounts = target.length[tuple(places.T)].astype(float)
    amounts *= total / amounts.sum()
    points = target.cell * (target.low + places)
    return [_on_grid(points, amounts, cell * 2**level) for level in range(levels)]


def _on_grid(points: np.ndarray, amounts: np.ndarray, cell: float) -> TargetGrid:
    """Splat amounts at points, (n, 3) [m], by B-splines."""
    u = points / cell
    nearest = np.floor(u + 0.5).astype(np.int64)
    low = nearest.min(axis=0) - 1
    shape = nearest.max(axis=0) - low + 2
    d = u - nearest
    flat = np.zeros(int(np.prod(shape)))
    weights = np.stack([0.5 * (0.5 - d) ** 2, 0.75 - d * d, 0.5 * (0.5 + d) ** 2])
    for a, b, c in np.ndindex(3, 3, 3):
        index = np.ravel_multi_index(tuple((nearest - low + (a - 1, b - 1, c - 1)).T), tuple(shape))
        shares = amounts * weights[a, :, 0] * weights[b, :, 1] * weights[c, :, 2]
        flat += np.bincount(index, shares, minlength=len(flat))
    return TargetGrid(low, cell, flat.reshape(shape) / cell**3)


def between(before: TargetGrid, after: TargetGrid, share: float) -> TargetGrid:
    """Return the mean of two densities on one lattice, `share` of the way to the second; pure."""
    low = np.minimum(before.low, after.low)
    shape = np.maximum(before.low + before.length.shape, after.low + after.length.shape) - low
    length = (1.0 - share) * placed(before, low, shape) + share * placed(after, low, shape)
    return TargetGrid(low, before.cell, length)


def placed(grid: TargetGrid, low: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return the density of a target on a box of nodes of its lattice, 0 where it does not reach; pure."""
    found = np.zeros(shape)
    first = np.maximum(grid.low, low)
    last = np.minimum(grid.low + grid.length.shape, low + shape)
    if (first < last).all():
        here = tuple(slice(a, b) for a, b in zip(first - low, last - low, strict=True))
        there = tuple(slice(a, b) for a, b in zip(first - grid.low, last - grid.low, strict=True))
        found[here] = grid.length[there]
    return found


class Hair(NamedTuple):
    """Strands attracted to a target.

    points   [m], (P, 3) float64; offsets  of strands, (S+1,) int32
    reach    see `sample_strands` [m], (S,)
    lengths  of hair at each point [m], (P,)
    """

    points: np.ndarray
    offsets: np.ndarray
    reach: np.ndarray
    lengths: np.ndarray


def attraction(hair: Hair, targets: list[TargetGrid], rate: float, dt: float) -> np.ndarray:
    """Return the change of velocity of points in a step of dt [s], (P, 3) [m/s]; pure.

    targets  on all grids; rate  w [1/s]
    """
    change = np.zeros_like(hair.points)
    limit = STIFFNESS * len(targets) * (rate * dt) ** 2
    for target in targets:
        samples = sample_strands(hair.points, hair.offsets, hair.reach, target.cell)
        if samples is None:
            continue
        density, wanted, seen = densities_in(samples, hair.lengths, target)
        field = (density - wanted) / seen
        field /= 1.0 + limit * np.maximum(density, wanted) / seen
        field *= -dt * (rate * target.cell) ** 2
        own = np.divide(hair.lengths, samples.sums, out=np.zeros(len(hair.lengths)), where=samples.sums > 0.0)
        add_slopes(samples, own, field, change)
    lengths = hair.lengths[:, None]
    return np.divide(change, lengths, out=change, where=lengths > 0.0)


def densities_in(
    samples: StrandSamples, lengths: np.ndarray, target: TargetGrid
) -> tuple[np.ndarray, np.ndarray, float]:
    """Find the density of hair of some lengths at points [m], (P,), and of a target on one box, and rho_0 [m/m^3]."""
    density = weigh(samples, lengths) / target.cell**3
    wanted = placed(target, samples.low.astype(np.int64) - 1, np.array(density.shape))
    return density, wanted, float(np.sum(target.length**2) / np.sum(target.length))


@dataclass(eq=False)
class VolumeTarget(Interaction):
    """The density target of a frame.

    offsets        offsets of the points of strands, (S+1,) int32
    reach          see `sample_strands` [m], (S,)
    lengths        length of hair at each point, at rest [m], (P,)
    before, after  density at the previous frame and at this one, on all grids
    frame_dt       time between the two [s]
    """

    in_solve = False
    target: Target
    offsets: np.ndarray
    reach: np.ndarray
    lengths: np.ndarray
    before: list[TargetGrid]
    after: list[TargetGrid]
    frame_dt: float

    def correct(self, end: StepEnd) -> None:
        """Change velocities, in place."""
        share = (end.time + end.dt) / self.frame_dt
        still = self.before is self.after
        now = self.after if still else [between(*pair, share) for pair in zip(self.before, self.after, strict=True)]
        hair = Hair(end.points, self.offsets, self.reach, self.lengths)
        change = attraction(hair, now, self.target.rate, end.dt)
        change[np.isinf(end.masses)] = 0.0
        end.push(change)


def volume_target(
    target: Target,
    densities: tuple[Density, Density],
    strands: tuple[np.ndarray, np.ndarray, np.ndarray],
    frame_dt: float,
) -> VolumeTarget:
    """Make a target from offsets, reach and lengths of strands and densities at the previous frame and at this one.

    Raises BadInput as `target_grids` does.
    """
    (before, after), (offsets, reach, lengths) = densities, strands
    grids = target_grids(after, target.cell, target.levels, lengths.sum())
    still = np.array_equal(before.low, after.low) and np.array_equal(before.length, after.length)
    first = grids if still else target_grids(before, target.cell, target.levels, lengths.sum())
    return VolumeTarget(target, offsets, reach, lengths, first, grids, frame_dt)
