"""Hair as a volume, after Petrovic, Henne, Anderson 2005: drag and pressure between strands, on a grid.

Once a step, after its solves and before the corrections of bodies and strain, strands are splatted on a grid. Friction
drives velocities to the average of the hair around a point, V(i) = (S v)(i),

    order 1   v' = v - (1 - exp(-c dt)) (1 - S) v
    order 2   v' = v - (1 - exp(-c dt)) (1 - S)^2 v

and pressure acts where hair is denser than its maximum. S is symmetric and between 0 and 1 in the norm of mass:
momentum is conserved to rounding, and friction never adds energy. Order 2 does not damp velocities that vary slowly in
space: a swing, a rotation, the motion of a hair alone in its cells.

We differ from the paper, whose friction is a force towards the velocities of the previous step: jointly accelerated
hair would be delayed, as if it had (1 + c dt) times its mass.

Velocities on the grid are smoothed by an exchange between neighbours, which conserves momentum:

    M_g V'_g = M_g V_g + sum_h k_gh (V_h - V_g),   k_gh = nu min(M_g, M_h),   over the six neighbours h

With nu <= 1/6, V' is a convex combination and energy never grows. We differ from Petrovic, Henne, Anderson 2005, whose
filter of V alone loses a thousandth of the momentum at the edge of hair, where a light node has a heavy neighbour.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.laws.pressure import densest, spread
from hairpipe.laws.settings import Volume
from hairpipe.solve.interactions import Interaction, StepEnd
from hairpipe.values.groom import reach_of
from hairpipe.volume.transfer import StrandSamples, collect, deposit, mean_velocities, sample_strands


@njit(cache=True, parallel=True, error_model="numpy")
def smooth(grid: np.ndarray, velocities: np.ndarray, nu: float, out: np.ndarray) -> None:
    """Write smoothed velocities of nodes, (nx, ny, nz, 3) [m/s], to out, in place.

    grid  whose first number at a node is its mass, (nx, ny, nz, 4)
    """
    nx, ny, nz = grid.shape[:3]
    for i in prange(nx):
        for j in range(ny):
            for k in range(nz):
                mass = grid[i, j, k, 0]
                sx, sy, sz = 0.0, 0.0, 0.0
                for axis in range(3):
                    for side in range(-1, 2, 2):
                        a = i + (side if axis == 0 else 0)
                        b = j + (side if axis == 1 else 0)
                        c = k + (side if axis == 2 else 0)
                        if mass > 0.0 and 0 <= a < nx and 0 <= b < ny and 0 <= c < nz:
                            # k_gh / M_g, by the lighter of the two: what one gives the other gets.
                            share = nu * min(1.0, grid[a, b, c, 0] / mass)
                            sx += share * (velocities[a, b, c, 0] - velocities[i, j, k, 0])
                            sy += share * (velocities[a, b, c, 1] - velocities[i, j, k, 1])
                            sz += share * (velocities[a, b, c, 2] - velocities[i, j, k, 2])
                out[i, j, k, 0] = velocities[i, j, k, 0] + sx
                out[i, j, k, 1] = velocities[i, j, k, 1] + sy
                out[i, j, k, 2] = velocities[i, j, k, 2] + sz


ACROSS = 3
"""Fewest cells along the longest side of hair at rest."""


@dataclass(eq=False)
class VolumeFilter(Interaction):
    """Friction between hairs and pressure on a grid.

    offsets  of the points of strands, (S+1,) int32
    masses   of the points, with particles off the axis, finite [kg], (P,)
    reach    see `sample_strands` [m], (S,)
    rest     density without pressure [kg/m^3]; 0 where there is none
    """

    in_solve = False
    volume: Volume
    offsets: np.ndarray
    masses: np.ndarray
    reach: np.ndarray
    rest: float = 0.0
    _nu: float = field(init=False)

    def __post_init__(self) -> None:
        self._nu = 1.0 / (6.0 * self.volume.order)

    def correct(self, end: StepEnd) -> None:
        """Change velocities, in place."""
        change = self.change(end.points, end.velocities, end.dt)
        change[np.isinf(end.masses)] = 0.0
        end.push(change)

    def change(self, points: np.ndarray, velocities: np.ndarray, dt: float) -> np.ndarray:
        """Return the change of velocities in a step of dt [s], (P, 3) [m/s]; pure."""
        samples = sample_strands(points, self.offsets, self.reach, self.volume.cell)
        if samples is None:
            return np.zeros_like(velocities)
        grid, smoothed = self._smoothed(samples, velocities)
        change = self._departures(samples, velocities, smoothed)
        if self.volume.order == 2:
            change = self._departures(samples, change, self._smoothed(samples, change)[1])
        change *= np.expm1(-self.volume.friction * dt)
        if self.volume.pressure is not None:
            pressed = smoothed.copy()
            spread(grid, pressed, self.volume.cell, self.rest, self.volume.pressure.compliance, dt)
            change += collect(samples, pressed - smoothed)
        return change

    def _departures(self, samples: StrandSamples, velocities: np.ndarray, smoothed: np.ndarray) -> np.ndarray:
        """Return the differences of velocities to the average around them [m/s], (P, 3); 0 for omitted strands."""
        means = collect(samples, smoothed)
        np.subtract(velocities, means, out=means)
        means[samples.sums == 0.0] = 0.0
        return means

    def _smoothed(self, samples: StrandSamples, velocities: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mass and momentum at nodes, and their smoothed velocities."""
        grid = deposit(samples, self.masses, velocities)
        before = np.empty((*samples.counts, 3))
        mean_velocities(grid, before)
        after = np.empty_like(before)
        for _ in range(self.volume.smoothing):
            smooth(grid, before, self._nu, after)
            before, after = after, before
        return grid, before


def rest_density(points: np.ndarray, offsets: np.ndarray, masses: np.ndarray, cell: float) -> float:
    """Return the largest density of a groom [kg/m^3], so that there is no pressure at rest; pure.

    Raises BadInput where cells are larger than the groom.
    """
    samples = sample_strands(points, offsets, reach_of(points, offsets), cell)
    assert samples is not None
    if max(samples.counts) - 2 < ACROSS:
        right = f"at most {cell * (max(samples.counts) - 1) / ACROSS / 2:.2g} m"
        raise BadInput(f"cells of {cell:g} m are as large as the hair", where="volume.cell", right=right)
    return densest(deposit(samples, masses, np.zeros_like(points)), cell)
