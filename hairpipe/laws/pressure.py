"""Unilateral pressure on a grid: hair spreads where its density exceeds a maximum (after McAdams et al. 2009).

A cell has the mean density rho of its eight corners, and with s = +-1 the side of a corner along an axis

    div = 1/(4h) sum_corners sum_axes s V

An impulse P = dt p >= 0 of the cell changes the velocities of its corners by dV = s h^2 P / (4 M_g), which conserves
momentum. It is the solution of

    div + a P >= b,   P >= 0,   P (div + a P - b) = 0,   a = compliance / (rho_0 dt^2),
    b = min((rho / rho_0 - 1) / dt, MOST_RATE)

b is negative in thin hair: it may be compressed until it is full. Solved by projected Gauss-Seidel, the cells of a
parity after those of another: they share no node. Only cells with hair at all eight corners have pressure, since what
has no mass takes no momentum. The explicit force of a density, in its place, is unstable at any step of a film.
"""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined

MOST_RATE = 10.0
"""Largest rate of expansion of cells that are too dense [1/s]."""
SWEEPS = 15


def spread(grid: np.ndarray, velocities: np.ndarray, cell: float, rest: float, compliance: float, dt: float) -> None:
    """Change velocities of nodes, (nx, ny, nz, 3) [m/s], by pressure in a step of dt [s], in place.

    grid        whose first number at a node is its mass [kg], (nx, ny, nz, 4)
    cell        [m]
    rest        density up to which there is no pressure [kg/m^3]
    compliance  [s^2/m^2]; 0: cells that are too dense are incompressible
    """
    mass = np.ascontiguousarray(grid[..., 0])
    filled = filled_cells(mass)
    colours = [np.argwhere(filled[i::2, j::2, k::2]) * 2 + (i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    cells = [np.ascontiguousarray(colour, np.int64) for colour in colours]
    impulses = [np.zeros(len(colour)) for colour in cells]
    numbers = cell, rest, compliance / (rest * dt * dt), dt
    for _ in range(SWEEPS):
        for colour, impulse in zip(cells, impulses, strict=True):
            _sweep(mass, colour, numbers, impulse, velocities)


def densest(grid: np.ndarray, cell: float) -> float:
    """Return the largest density of a cell that can have pressure [kg/m^3], or 0; grid and cell as of `spread`."""
    mass = np.ascontiguousarray(grid[..., 0])
    return float(_densities(mass, cell).max(initial=0.0, where=filled_cells(mass)))


def _densities(mass: np.ndarray, cell: float) -> np.ndarray:
    """Return the mean density of the corners of every cell [kg/m^3], (nx-1, ny-1, nz-1), summed as `_sweep` does."""
    total = np.zeros(tuple(n - 1 for n in mass.shape))
    for a in range(2):
        for b in range(2):
            for c in range(2):
                corner = (slice(side, side - 1 or None) for side in (a, b, c))
                total += mass[tuple(corner)]
    return total / (8.0 * cell**3)


def filled_cells(mass: np.ndarray) -> np.ndarray:
    """Return which cells have mass at all eight corners, (nx-1, ny-1, nz-1) bool."""
    filled = mass > 0.0
    for axis in range(3):
        first, second = (tuple(slice(n, n - 1 or None) if a == axis else slice(None) for a in range(3)) for n in (0, 1))
        filled = filled[first] & filled[second]
    return filled


@njit(cache=True, parallel=True, error_model="numpy")
def _sweep(mass, cells, numbers, impulses, velocities):
    """Add the missing impulse to cells of one parity, (n, 3), in place."""
    cell, rest, yielding, dt = numbers
    for n in prange(len(cells)):  # Cells of one parity share no node: no two threads write one velocity.
        i, j, k = cells[n, 0], cells[n, 1], cells[n, 2]
        density, divergence, inverse = 0.0, 0.0, 0.0
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    m = mass[i + a, j + b, k + c]
                    density += m
                    inverse += 1.0 / m
                    divergence += _along(velocities, i + a, j + b, k + c, a, b, c)
        density /= 8.0 * cell**3
        # Negative in thin hair, which may be compressed until it is full; bounded where hair is much too dense.
        wanted = min((density / rest - 1.0) / dt, MOST_RATE)
        lack = wanted - divergence / (4.0 * cell) - yielding * impulses[n]
        # The sum over all sweeps is clamped, not the change: an earlier push may be taken back.
        impulse = max(0.0, impulses[n] + lack / (3.0 * cell / 16.0 * inverse + yielding))
        more = 0.25 * cell**2 * (impulse - impulses[n])
        impulses[n] = impulse
        if more != 0.0:  # A cell without pressure writes nothing.
            for a in range(2):
                for b in range(2):
                    for c in range(2):
                        change = more / mass[i + a, j + b, k + c]
                        velocities[i + a, j + b, k + c, 0] += change if a else -change
                        velocities[i + a, j + b, k + c, 1] += change if b else -change
                        velocities[i + a, j + b, k + c, 2] += change if c else -change


@inlined
def _along(velocities, i, j, k, a, b, c):
    """Return the velocity of a node outward of the cell that has it at corner a, b, c, along all three axes."""
    x, y, z = velocities[i, j, k, 0], velocities[i, j, k, 1], velocities[i, j, k, 2]
    return (x if a else -x) + (y if b else -y) + (z if c else -z)
