"""Air as an interaction with strands, and with particles, each of which represents a number of parallel fibres.

Shielding reduces the wind behind hair. In a volume V with segments of lengths L at angles q to the wind, drag removes
momentum of the air along the wind. With U the speed of the wind and s the distance along it, its balance is

    rho U dU/ds = -sum L c_n U sin^2 q / V,   c_n = (1/2) rho d C_D U   (see `laws/drag.py`)

    dU/ds = -(1/2) C_D a U,   a = sum L d sin^2 q / V

where a is the frontal area of hair per volume, sum L d sin q / V, weighted once more with sin q, as the drag of a fibre
acts across it and not along the wind. Drag along the fibre is omitted. a is splatted on a grid whose first axis is that
of the wind, and U is marched from upwind to downwind in every column; at a point it is interpolated between the nodes.
Behind the hair the wind does not recover, and the body does not shield.
"""

from dataclasses import replace
from math import hypot
from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.rotations import frame_along
from hairpipe.geometry.trilinear import sample, splat, voxel_at
from hairpipe.laws.drag import Law, add_drag_of_segment, law_of, normal_drag
from hairpipe.laws.gusts import add_gusts, modes_of
from hairpipe.laws.settings import Wind
from hairpipe.solve.interactions import Interaction, Prediction, Start

MOST_NODES = 1 << 22
"""Largest number of nodes of the grid, 32 MB: its cells are doubled until it is at most this large."""

_NOTHING = 1e-6
"""Least share of the wind, so that its Reynolds number is not zero."""


class Shield(NamedTuple):
    """Share of the wind at the nodes of a grid.

    axes   unit vectors of the grid, along the wind and across it, in rows, (3, 3)
    low    coordinates of the first node along the axes, in cells, (3,) int64
    cell   [m]
    left   share of the undisturbed wind, (nx, ny, nz)
    """

    axes: np.ndarray
    low: np.ndarray
    cell: float
    left: np.ndarray


def shield_of(
    points: np.ndarray,
    offsets: np.ndarray,
    wind: Wind,
    law: Law,
    diameter: float,
    widths: np.ndarray | None = None,
    sizes: np.ndarray | None = None,
) -> Shield | None:
    """Rasterise the frontal area of hair and march the wind through it; None without shielding, hair or wind.

    points    of the axes [m], (P, 3); offsets  of their strands, (S+1,) int32
    diameter  of the law [m]
    widths    of segments, roots of the numbers of hairs that they represent, (P,); None: 1
    sizes     diameters of segments over that of the law, (P,); None: 1
    """
    speed = float(np.linalg.norm(wind.velocity))
    if wind.shielding is None or speed == 0.0:
        return None
    axes = np.ascontiguousarray(frame_along(np.array(wind.velocity) / speed)[:, [2, 0, 1]].T)
    bounds = _bounds(points, axes)
    if bounds[0, 0] > bounds[1, 0]:
        return None
    cell = wind.shielding.cell
    while np.prod(np.diff(np.floor(bounds / cell), axis=0) + 2.0) > MOST_NODES:
        cell *= 2.0
    low, high = np.floor(bounds / cell)
    counts = high - low + 2.0
    low = low.astype(np.int64)
    area = np.zeros(tuple(counts.astype(int)))
    hairs = np.ones(len(points)) if widths is None else widths**2
    if sizes is not None and np.isnan(law.normal):  # a prescribed coefficient is that of any diameter
        hairs = hairs * _drag_shares(law, sizes, speed)
    _count(points, offsets, axes, low, cell, wind.shielding.hairs * diameter, hairs, area)
    left = np.empty_like(area)
    _march(area / cell**3, law, wind.density * diameter, speed, cell, left)
    return Shield(axes, low, cell, left)


@njit(cache=True)
def _bounds(points, axes):
    """Return the least and the greatest coordinates along the axes [m], (2, 3), of points that are finite."""
    least = np.full(3, np.inf)
    greatest = np.full(3, -np.inf)
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        if np.isfinite(x + y + z):  # A lost point must not enlarge the grid.
            for axis in range(3):
                place = axes[axis, 0] * x + axes[axis, 1] * y + axes[axis, 2] * z
                least[axis] = min(least[axis], place)
                greatest[axis] = max(greatest[axis], place)
    return np.stack((least, greatest))


@inlined
def _coordinates(axes, low, cell, x, y, z):
    """Return the coordinates of a place [m] in the grid, in cells from its first node."""
    u = (axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z) / cell - low[0]
    v = (axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z) / cell - low[1]
    w = (axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z) / cell - low[2]
    return u, v, w


@njit(cache=True)
def _drag_shares(law, sizes, speed):
    """Return c_n of segments over that of the law, in the undisturbed wind: a segment counts by its drag, (P,)."""
    shares = np.empty(len(sizes))
    for k in range(len(sizes)):  # A Reynolds number is proportional to its diameter.
        shares[k] = normal_drag(law, sizes[k] * speed) / normal_drag(law, speed)
    return shares


@njit(cache=True, error_model="numpy")
def _count(points, offsets, axes, low, cell, width, hairs, area):
    """Add L width hairs sin^2 q of segments to the eight nodes around them [m^2], in place; long ones in pieces."""
    for strand in range(len(offsets) - 1):
        for k in range(offsets[strand], offsets[strand + 1] - 1):
            x, y, z = points[k, 0], points[k, 1], points[k, 2]
            dx, dy, dz = points[k + 1, 0] - x, points[k + 1, 1] - y, points[k + 1, 2] - z
            squared = dx * dx + dy * dy + dz * dz
            along = axes[0, 0] * dx + axes[0, 1] * dy + axes[0, 2] * dz
            if 0.0 < squared < np.inf:
                length = np.sqrt(squared)
                pieces = int(2.0 * length / cell) + 1  # At most half a cell each: no gap between nodes.
                facing = width * hairs[k] * (squared - along * along) / length / pieces
                for piece in range(pieces):
                    s = (piece + 0.5) / pieces
                    u, v, w = _coordinates(axes, low, cell, x + s * dx, y + s * dy, z + s * dz)
                    splat(area, voxel_at(area, u, v, w), facing)


@njit(cache=True, parallel=True, error_model="numpy")
def _march(density, law, line, speed, cell, left):
    """March the wind along the first axis: dU/ds = -c_n(U) a / (rho d), by the midpoint rule for ln U.

    density  a at the nodes [1/m]; line  rho d [kg/m^2]; left  U at the nodes over the undisturbed speed
    """
    for j in prange(density.shape[1]):  # Columns are independent; in each, a node needs the one before it.
        for k in range(density.shape[2]):
            share = 1.0
            for i in range(density.shape[0]):
                middle = share
                if density[i, j, k] > 0.0:
                    thickness = cell * density[i, j, k] / line
                    middle = max(share * np.exp(-0.5 * thickness * _rate(law, share * speed)), _NOTHING)
                    share = max(share * np.exp(-thickness * _rate(law, middle * speed)), _NOTHING)
                left[i, j, k] = middle  # Half of the hair of the cell is upstream of its node.


@inlined
def _rate(law, speed):
    """Drag of a metre of hair over its speed squared [N s^2/m^3]."""
    return normal_drag(law, speed) / speed


@njit(cache=True, parallel=True)
def weaken(shield: Shield, points: np.ndarray, air: np.ndarray) -> None:
    """Multiply the velocity of the air [m/s], (P, 3), by the share of the shield at points [m], (P, 3), in place."""
    for p in prange(len(points)):
        share = fraction(shield, points[p, 0], points[p, 1], points[p, 2])
        for c in range(3):
            air[p, c] *= share


@inlined
def fraction(shield: Shield, x: float, y: float, z: float) -> float:
    """Return the share of the wind that is left at a place [m]; beyond the grid, that at its border."""
    u, v, w = _coordinates(shield.axes, shield.low, shield.cell, x, y, z)
    return sample(shield.left, voxel_at(shield.left, u, v, w))


@njit(cache=True, parallel=True, error_model="numpy")
def add_drag(
    at: Prediction,
    air: np.ndarray,
    offsets: np.ndarray,
    law: Law,
    sizes: np.ndarray,
    push: np.ndarray,
    damping: np.ndarray,
) -> None:
    """Add the force push - damping v of the air on active points, in place; values of the others are not read."""
    for strand in prange(len(offsets) - 1):
        end = offsets[strand + 1] if at.active[offsets[strand]] else offsets[strand]  # A strand is active as a whole.
        for k in range(offsets[strand], end - 1):  # One thread per strand: segments add to common points in order.
            add_drag_of_segment(at.points, at.lagged_velocity, air, k, law, sizes[k], push, damping)


STORM = 115.0
"""Speed of the strongest gust that was measured near the ground, in 1996, rounded up [m/s]."""


def warn_of_storm(wind: Wind | None) -> None:
    """Warn of a mean velocity above that of any storm."""
    speed = 0.0 if wind is None else hypot(*wind.velocity)
    if speed > STORM:
        message = f"wind.velocity has {speed:,.0f} m/s, above {STORM:.0f} m/s, the strongest gust ever measured"
        warn(f"{message} (velocities are in m/s)", stacklevel=3)


class Breeze(Interaction):
    """Wind over hair; offsets of its strands, (S+1,) int32, and widths of segments, see `shield_of`."""

    def __init__(
        self,
        wind: Wind,
        diameter: float,
        offsets: np.ndarray,
        widths: np.ndarray | None = None,
        diameters: np.ndarray | None = None,
    ) -> None:
        """Draw the gusts, and find the drag of hair of a mean diameter, and of diameters at points, (P,) [m]."""
        self.wind = wind
        self.diameter = diameter
        self.offsets = offsets
        self.widths = widths
        self.law = law_of(wind, diameter)
        self.varied = None
        if diameters is not None:  # At segments: the mean of a point and the next one, unused for the last of a strand.
            sizes = diameters / np.float64(diameter)
            self.varied = 0.5 * (sizes + np.roll(sizes, -1))
        self.modes = modes_of(wind.gusts) if wind.gusts else None
        self._shield: Shield | None = None

    def begin(self, start: Start) -> None:
        """Count the shielding hair once for all solves of a step."""
        self._shield = self._counted(start.points)

    def air(self, points: np.ndarray, seconds: float) -> np.ndarray:
        """Return the velocity of the air at points of hair, (P, 3) [m], at an absolute time of the shot [m/s], (P, 3).

        It is the mean wind and its gusts, reduced by the hair upstream.
        """
        return self._air(points, self._shield or self._counted(points), seconds)

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the force push - damping v of the air, in place; gusts depend on the time of the shot."""
        air = np.empty_like(at.points)
        some = slice(None) if at.active.all() else at.active
        air[some] = self._air(at.points[some], self._shield or self._counted(at.points), at.seconds)
        sizes = np.ones(len(at.points)) if self.varied is None else self.varied
        add_drag(at, air, self.offsets, self.law, sizes, push, damping)

    def _counted(self, points: np.ndarray) -> Shield | None:
        """Return the shielding hair."""
        return shield_of(points, self.offsets, self.wind, self.law, self.diameter, self.widths, self.varied)

    def _air(self, points: np.ndarray, shield: Shield | None, seconds: float) -> np.ndarray:
        """Return the velocity of the air at some points behind a shield; otherwise as `air`."""
        velocity = np.array(self.wind.velocity)
        air = np.tile(velocity, (len(points), 1))
        if self.modes is not None:
            add_gusts(self.modes, velocity, points, seconds, air)
        if shield is not None:
            weaken(shield, points, air)
        return air


class StillAir(Interaction):
    """Still air whose drag varies: its damping [kg/s] at every point, (P,), the rate times the mass that moves with it.

    The stages themselves contain the drag of one rate everywhere, which costs nothing.
    """

    def __init__(self, damping: np.ndarray) -> None:
        self.damping = damping

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the force -damping v, in place."""
        for diagonal in (0, 3, 5):
            damping[:, diagonal] += self.damping


class LooseFibres(NamedTuple):
    """Segments of fibre at particles.

    points, directions, velocities  [m], unit vectors, [m/s], (N, 3) each
    counts                          number of parallel fibres, (N,)
    segment                         length of each [m]
    diameter                        of a fibre [m]
    """

    points: np.ndarray
    directions: np.ndarray
    velocities: np.ndarray
    counts: np.ndarray
    segment: float
    diameter: float


def add_wind(wind: Wind, hair: LooseFibres, seconds: float, push: np.ndarray, drag: np.ndarray) -> None:
    """Add the force push - drag v of the air at a time of the shot [s], in place.

    push  [N], (N, 3)
    drag  symmetric xx xy xz yy yz zz [kg/s], (N, 6)

    All fibres of a particle shield other hair.
    """
    if wind.shielding is not None:
        hairs = wind.shielding.hairs * float(hair.counts.mean())
        wind = replace(wind, shielding=replace(wind.shielding, hairs=hairs))
    half = 0.5 * hair.segment * hair.directions
    count = len(hair.counts)
    ends = np.stack([hair.points - half, hair.points + half], axis=1).reshape(-1, 3)
    pace = np.repeat(hair.velocities, 2, axis=0)
    still = np.zeros(2 * count)
    at = Prediction(ends, pace, pace, still, still, np.ones(2 * count, bool), 0.0, 0.0, seconds)
    pushes, drags = np.zeros((2 * count, 3)), np.zeros((2 * count, 6))
    offsets = np.arange(0, 2 * count + 1, 2, dtype=np.int32)
    Breeze(wind, hair.diameter, offsets).linearise(at, pushes, drags)
    push += hair.counts[:, None] * pushes.reshape(count, 2, 3).sum(axis=1)
    drag += hair.counts[:, None] * drags.reshape(count, 2, 6).sum(axis=1)
